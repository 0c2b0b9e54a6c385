// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/mesh/gmsh_session.hpp"

#include <gmsh.h>

#include <algorithm>

namespace drogue::mesh {
namespace {

constexpr const char* model_name = "drogue_session";

std::mutex& gmsh_mutex() {
  static std::mutex mutex;
  return mutex;
}

void initialise() {
  gmsh::initialize(0, nullptr, false);
  gmsh::option::setNumber("General.Terminal", 0);
  gmsh::option::setNumber("Mesh.Renumber", 0);
}

/// Asks nothing before initialising: a Gmsh that is not initialised may end the process on any other call,
/// whereas one that already is only warns.
void initialise_once() {
  static std::once_flag once;
  std::call_once(once, initialise);
}

std::vector<int> view_tags() {
  std::vector<int> tags;
  gmsh::view::getTags(tags);
  return tags;
}

} // namespace

GmshSession::GmshSession() : lock_(gmsh_mutex()) {
  initialise_once();
  gmsh::model::getCurrent(previous_model_);
  previous_views_ = view_tags();
  gmsh::model::add(model_name);
}

GmshSession::~GmshSession() {
  for (const int tag : new_views()) gmsh::view::remove(tag);
  gmsh::model::setCurrent(model_name);
  gmsh::model::remove();
  gmsh::model::setCurrent(previous_model_);
}

std::vector<int> GmshSession::new_views() const {
  std::vector<int> added;
  for (const int tag : view_tags())
    if (std::find(previous_views_.begin(), previous_views_.end(), tag) == previous_views_.end())
      added.push_back(tag);
  return added;
}

void restart_gmsh() {
  const std::unique_lock<std::mutex> lock(gmsh_mutex());
  gmsh::finalize();
  initialise();
}

std::string gmsh_reason(const std::string& otherwise) {
  std::string reason;
  gmsh::logger::getLastError(reason);
  return reason.empty() ? otherwise : reason;
}

} // namespace drogue::mesh
