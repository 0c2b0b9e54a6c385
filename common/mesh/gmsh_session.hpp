// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <mutex>
#include <string>
#include <vector>

namespace drogue::mesh {

/// Gmsh is one global object in a process. A session holds the lock on it, gives an empty model of its own,
/// and leaves Gmsh as it was found: the model and the views that came with the session are removed at its
/// end, and the model that was current before is current again. Gmsh itself is initialised by the first
/// session, silent and without the user's configuration files, and stays so until the process ends.
class GmshSession {
 public:
  GmshSession();
  ~GmshSession();
  GmshSession(const GmshSession&) = delete;
  GmshSession& operator=(const GmshSession&) = delete;

  /// Tags of the views that were added in this session.
  [[nodiscard]] std::vector<int> new_views() const;

 private:
  std::unique_lock<std::mutex> lock_;
  std::string previous_model_;
  std::vector<int> previous_views_;
};

/// Starts Gmsh anew. After a mesh that could not be made it makes no other one. @pre no session is open
void restart_gmsh();

/// What Gmsh reported last as an error; `otherwise` when it reported nothing.
[[nodiscard]] std::string gmsh_reason(const std::string& otherwise);

} // namespace drogue::mesh
