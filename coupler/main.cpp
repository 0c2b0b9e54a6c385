// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/command_line.hpp"

int main(int argc, char** argv) {
  return drogue::coupler::command_line(argc, argv);
}
