// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace drogue::test {

/// Prefix of a command, for a shell, that gets a signal as soon as the file `log` in its folder, into which
/// its output goes, holds `text`; after a minute in any case.
inline std::string signalled(const std::string& signal, const std::string& text) {
  return "sh -c '\"$@\" & i=0; until grep -q \"" + text + "\" log || [ $i -gt 1200 ]; do sleep 0.05; " +
         "i=$((i + 1)); done; kill -s " + signal + " $!; wait $!' sh ";
}

} // namespace drogue::test
