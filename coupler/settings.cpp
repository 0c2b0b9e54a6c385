// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/settings.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <google/protobuf/text_format.h>

#include "common/base/hash.hpp"
#include "drogue/v1/coupler.pb.h"
#include "participant/cpp/keys.hpp"

namespace drogue::coupler {
namespace {

NonConvergence from(v1::CouplingLoop::NonConvergence policy) {
  switch (policy) {
  case v1::CouplingLoop::ABORT:
    return NonConvergence::abort;
  case v1::CouplingLoop::ACCEPT:
    return NonConvergence::accept;
  case v1::CouplingLoop::RETRY:
    return NonConvergence::retry;
  }
  return NonConvergence::abort;
}

Scheme from(v1::CouplingLoop::Scheme scheme) {
  switch (scheme) {
  case v1::CouplingLoop::SERIAL:
    return Scheme::serial;
  case v1::CouplingLoop::PARALLEL:
    return Scheme::parallel;
  case v1::CouplingLoop::STRUCTURE_FIRST:
    return Scheme::structure_first;
  }
  return Scheme::serial;
}

LoadTime from(v1::CouplingLoop::Load load) {
  switch (load) {
  case v1::CouplingLoop::MATCHING:
    return LoadTime::matching;
  case v1::CouplingLoop::END_OF_STEP:
    return LoadTime::end_of_step;
  case v1::CouplingLoop::MEAN_OF_STEP:
    return LoadTime::mean_of_step;
  case v1::CouplingLoop::EXTRAPOLATED_MEAN:
    return LoadTime::extrapolated_mean;
  }
  return LoadTime::matching;
}

acceleration::Method from(v1::Acceleration::Method method) {
  switch (method) {
  case v1::Acceleration::CONSTANT:
    return acceleration::Method::constant;
  case v1::Acceleration::AITKEN:
    return acceleration::Method::aitken;
  case v1::Acceleration::IQN_ILS:
    return acceleration::Method::iqn_ils;
  case v1::Acceleration::IQN_IMVJ:
    return acceleration::Method::iqn_imvj;
  }
  return acceleration::Method::iqn_ils;
}

std::string with_config_dir(std::string argument, const std::filesystem::path& folder) {
  const std::string key = "${config_dir}";
  for (std::size_t at = argument.find(key); at != std::string::npos; at = argument.find(key))
    argument.replace(at, key.size(), folder.string());
  return argument;
}

ParticipantSettings participant(const v1::ParticipantConfig& p, const std::string& name,
                                const std::string& path, const config::Source& source,
                                config::Report& report) {
  ParticipantSettings s;
  s.name = name;
  s.path = path;
  const auto folder = std::filesystem::absolute(source.file()).parent_path();
  s.command = with_config_dir(p.command(), folder);
  s.command_position = source.where(path + ".command");
  for (const std::string& a : p.argument()) s.arguments.push_back(with_config_dir(a, folder));
  if (p.has_config()) s.config = std::filesystem::absolute(source.resolve(p.config()));
  s.ranks = p.ranks();
  s.by_hand = p.launch() == v1::ParticipantConfig::NONE;
  if (p.has_public_key()) s.public_key = std::filesystem::absolute(source.resolve(p.public_key()));
  s.directory = p.directory();
  if (!s.by_hand && (p.has_public_key() || p.has_directory()))
    report.error(source.where(path + (p.has_public_key() ? ".public_key" : ".directory")),
                 "this goes with launch NONE alone");
  if (p.has_directory() && !s.directory.is_absolute())
    report.error(source.where(path + ".directory"), fmt::format("\"{}\" is not absolute", p.directory()));
  for (int i = 0; i < p.environment_size(); ++i) {
    s.environment.push_back(p.environment(i));
    if (p.environment(i).find('=') == std::string::npos || p.environment(i).front() == '=')
      report.error(source.where(fmt::format("{}.environment[{}]", path, i)),
                   fmt::format("\"{}\" is not of the form NAME=value", p.environment(i)));
  }
  if (p.has_config() == (p.argument_size() > 0))
    report.error(source.where(path), name + " needs either a config (one of Drogue's solvers) or arguments");
  return s;
}

/// A name of a folder, and no other participant's.
bool can_be_named(const std::string& name) {
  constexpr const char* plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
  return !name.empty() && name.find_first_not_of(plain) == std::string::npos && name != "fluid" &&
         name != "mesh_mover";
}

std::vector<ParticipantSettings> structures(const v1::CaseConfig& c, const config::Source& source,
                                            config::Report& report) {
  std::vector<ParticipantSettings> all;
  std::set<std::string> names;
  for (int i = 0; i < c.structure_size(); ++i) {
    const v1::ParticipantConfig& p = c.structure(i);
    const std::string path = fmt::format("structure[{}]", i);
    const std::string name = p.has_name() ? p.name() : "structure";
    if (c.structure_size() > 1 && !p.has_name())
      report.error(source.where(path),
                   fmt::format("{} needs a name: there are {} structures", path, c.structure_size()));
    else if (!can_be_named(name))
      report.error(
          source.where(path + ".name"),
          fmt::format("a structure cannot be called \"{}\": letters, digits, - and _ make a name, and "
                      "fluid and mesh_mover are taken",
                      name));
    else if (!names.insert(name).second)
      report.error(source.where(path + ".name"), fmt::format("there are two structures \"{}\"", name));
    all.push_back(participant(p, name, path, source, report));
  }
  return all;
}

/// The fluid or the mesh mover.
ParticipantSettings only(const v1::ParticipantConfig& p, const std::string& name,
                         const config::Source& source, config::Report& report) {
  if (p.has_name())
    report.error(source.where(name + ".name"), fmt::format("{} has its name: only structures get one", name));
  return participant(p, name, name, source, report);
}

bool is_tcp(const std::string& endpoint) {
  const std::string start = "tcp://";
  const std::size_t colon = endpoint.rfind(':');
  if (endpoint.rfind(start, 0) != 0 || colon <= start.size()) return false;
  const std::string port = endpoint.substr(colon + 1);
  return port == "*" || (!port.empty() && port.find_first_not_of("0123456789") == std::string::npos &&
                         port.size() <= 5 && std::stoi(port) <= 65535);
}

NetworkSettings network(const v1::Network& n, const config::Source& source, config::Report& report) {
  NetworkSettings s{n.endpoint(), n.connect(), {}};
  if (!is_tcp(s.endpoint))
    report.error(source.where("network.endpoint"),
                 fmt::format("\"{}\" is not of the form tcp://HOST:PORT", s.endpoint));
  else if (!n.has_key() && !keys::stays_on_this_machine(s.endpoint))
    report.error(
        source.where("network.endpoint"),
        fmt::format(
            "{} can be reached from other machines: network.key is needed (coupler keygen makes one), "
            "or a loopback address, tcp://127.0.0.1:PORT",
            s.endpoint));
  if (!s.connect.empty() && !is_tcp(s.connect))
    report.error(source.where("network.connect"),
                 fmt::format("\"{}\" is not of the form tcp://HOST:PORT", s.connect));
  if (n.has_key()) s.key = std::filesystem::absolute(source.resolve(n.key()));
  return s;
}

/// Keys go together, and are keys.
void check_keys(const CaseSettings& s, const config::Source& source, config::Report& report) {
  std::error_code failure;
  if (std::filesystem::is_regular_file(s.network.key, failure))
    if (const auto own = keys::read_pair(s.network.key); !own)
      report.error(source.where("network.key"), own.error().message);
  for (const ParticipantSettings* p : participants_of(s)) {
    if (!p->by_hand) continue;
    if (p->public_key.empty() != s.network.key.empty())
      report.error(source.where(p->path),
                   fmt::format("{}.public_key and network.key go together: {} is missing", p->name,
                               p->public_key.empty() ? "the first" : "the second"));
    if (std::filesystem::is_regular_file(p->public_key, failure))
      if (const auto key = keys::read_public(p->public_key); !key)
        report.error(source.where(p->path + ".public_key"), key.error().message);
  }
}

LoopSettings loop(const v1::CouplingLoop& l, const config::Source& source, config::Report& report) {
  if (l.min_iterations() > l.max_iterations())
    report.error(source.where("loop.min_iterations"), "loop.min_iterations is above loop.max_iterations");
  LoopSettings s;
  s.relative = l.relative();
  s.absolute = l.absolute();
  s.floor = l.floor();
  s.max_iterations = l.max_iterations();
  s.min_iterations = l.min_iterations();
  s.predictor = l.predictor();
  s.non_convergence = from(l.non_convergence());
  s.max_halvings = l.max_halvings();
  s.divergence = l.divergence();
  s.wall_velocity = l.wall_velocity() == v1::CouplingLoop::MESH_RATE ? WallVelocity::mesh_rate
                                                                     : WallVelocity::structure_rate;
  s.inner_residual = l.inner_residual();
  s.load = from(l.load());
  const bool wants_end = s.load == LoadTime::end_of_step || s.load == LoadTime::extrapolated_mean;
  if (s.wall_velocity == WallVelocity::mesh_rate && wants_end)
    report.error(
        source.where("loop.load"),
        fmt::format(
            "loop.load {} does not go with loop.wall_velocity MESH_RATE: the pair converges to a wrong "
            "answer; take MEAN_OF_STEP, or STRUCTURE_RATE",
            v1::CouplingLoop::Load_Name(l.load())));
  s.scheme = from(l.scheme());
  s.residual_relative = l.residual_relative();
  s.velocity_relative = l.velocity_relative();
  s.load_relative = l.load_relative() > 0 || s.scheme != Scheme::parallel ? l.load_relative() : l.relative();
  s.stall = l.stall();
  return s;
}

acceleration::Settings accelerator(const v1::Acceleration& a) {
  return {from(a.method()), a.relaxation(), a.max_relaxation(), a.reuse_steps(), a.filter(), a.max_columns()};
}

/// e / (1/2 rho U^2 A), e of length one.
std::array<double, 3> drag_weights(const v1::DragReference& d, const config::Source& source,
                                   config::Report& report) {
  const double length = std::hypot(d.direction_x(), d.direction_y(), d.direction_z());
  if (!(length > 0)) report.error(source.where("drag"), "the direction of the drag has length zero");
  const double scale = length * 0.5 * d.density() * d.speed() * d.speed() * d.area();
  return {d.direction_x() / scale, d.direction_y() / scale, d.direction_z() / scale};
}

/// Equal for two cases of equal results, whatever their layout and comments.
std::string hash_of(v1::CaseConfig c) {
  c.clear_run_directory();
  c.clear_deadlines();
  c.clear_checkpoints();
  c.clear_healing();
  c.clear_network();
  const auto forget_place = [](v1::ParticipantConfig& p) {
    p.clear_launch();
    p.clear_public_key();
    p.clear_directory();
  };
  forget_place(*c.mutable_fluid());
  forget_place(*c.mutable_mesh_mover());
  for (v1::ParticipantConfig& p : *c.mutable_structure()) forget_place(p);
  c.mutable_time()->clear_steps();
  std::string text;
  google::protobuf::TextFormat::PrintToString(c, &text);
  Hash hash;
  hash.add(text);
  return hash.text();
}

constexpr int default_restarts = 3;

/// Whether all participants are programs of Drogue's own, known to do the same again after a restart.
bool all_built_in(const CaseSettings& s) {
  const auto is = [](const ParticipantSettings& p, const char* program) {
    return !p.by_hand && std::filesystem::path(p.command).filename() == program;
  };
  return is(s.fluid, "fluid_solver") && is(s.mesh_mover, "mesh_mover") &&
         std::all_of(s.structures.begin(), s.structures.end(),
                     [&](const auto& structure) { return is(structure, "structure_solver"); });
}

} // namespace

std::vector<const ParticipantSettings*> participants_of(const CaseSettings& settings) {
  std::vector<const ParticipantSettings*> all{&settings.fluid};
  for (const ParticipantSettings& structure : settings.structures) all.push_back(&structure);
  all.push_back(&settings.mesh_mover);
  return all;
}

CaseSettings load_case(const std::filesystem::path& file, config::Report& report) {
  v1::CaseConfig c;
  const config::Source source = config::load(file, c, report);
  CaseSettings s;
  if (!source.parsed()) return s;
  s.file = std::filesystem::absolute(file);
  s.name = c.name();
  s.run_directory = c.run_directory();
  if (c.has_fluid()) s.fluid = only(c.fluid(), "fluid", source, report);
  s.structures = structures(c, source, report);
  if (c.has_mesh_mover()) s.mesh_mover = only(c.mesh_mover(), "mesh_mover", source, report);
  s.time_step = c.time().step();
  s.steps = c.time().steps();
  s.loop = loop(c.loop(), source, report);
  s.acceleration = accelerator(c.acceleration());
  if (s.loop.scheme == Scheme::parallel && s.acceleration.method == acceleration::Method::aitken)
    report.error(source.where("acceleration.method"),
                 "acceleration.method AITKEN does not go with loop.scheme PARALLEL: displacement and load "
                 "need more than "
                 "one factor; take IQN_ILS or IQN_IMVJ");
  const v1::ProjectionConfig& p = c.projection();
  s.projection = {p.largest_gap(), p.quadrature_order(), p.largest_unmatched_area(),
                  p.largest_normal_angle()};
  const v1::Deadlines& d = c.deadlines();
  s.deadlines = {d.connect(), d.initialize(), d.iterate(), d.other(), d.shutdown(), d.by_hand()};
  const v1::Checkpoints& k = c.checkpoints();
  s.checkpoints = {k.steps(), k.time(), k.wall_clock(), k.keep()};
  s.network = network(c.network(), source, report);
  check_keys(s, source, report);
  s.restarts = c.healing().has_restarts() ? c.healing().restarts() : all_built_in(s) ? default_restarts : 0;
  s.hash = hash_of(c);
  if (auto factor = config::Expression::parse(c.load_factor())) s.load_factor = std::move(*factor);
  if (auto share = config::Expression::parse(c.withheld_first_load()))
    s.withheld_first_load = std::move(*share);
  s.outer_boundary_follows = c.outer_boundary() == v1::FOLLOW_MEAN;
  if (c.has_start_from())
    s.start_from = std::filesystem::absolute(source.resolve(c.start_from())).lexically_normal();
  if (c.has_drag()) s.drag_weights = drag_weights(c.drag(), source, report);
  return s;
}

} // namespace drogue::coupler
