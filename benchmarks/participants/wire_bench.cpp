// SPDX-License-Identifier: GPL-3.0-or-later
//
// The way of a message between the coupler and a participant in a process of its own: the round trip of an
// Iterate without fields, and the crossing of an array of 100 MB, from its values on one side to its checked
// values on the other (both checksums, the copy and the search for values that are not finite included), over
// ipc and over TCP on the loopback; and a checkpoint of the T-10 at the paper's size [stein2001]: states of
// 133,097 fluid nodes and 9,183 structure nodes, written, brought onto the disk and listed with their
// checksums. Targets: 100 us; 1.0 and 0.8 GB/s; 2 s. Prints rows as Google Benchmark's csv does:
// name,iterations,value,value,unit.
#include <algorithm>
#include <csignal>
#include <cstdlib>

#include <spdlog/spdlog.h>
#include <sys/wait.h>

#include "benchmarks/support/measure.hpp"
#include "common/io/state_file.hpp"
#include "coupler/checkpoint_store.hpp"
#include "participant/cpp/participant.hpp"
#include "participant/cpp/wire.hpp"

namespace drogue {
namespace {

namespace fs = std::filesystem;
using namespace bench;
using participant::FloatArray;
using C = v1::FieldContract;

constexpr std::uint64_t large_nodes = 4'166'667; // times 3 components of 8 bytes: 100 MB
constexpr int round_trips = 20'000, crossings = 12;

/// Takes a field, or none, and gives nothing.
class Sink : public participant::Solver {
 public:
  explicit Sink(std::uint64_t nodes) : nodes_(nodes) {}
  participant::Description describe() override {
    participant::Description d;
    d.software = "sink";
    if (nodes_ > 0) d.inputs = {participant::field("force", C::FORCE, C::MESH_NODES, 3)};
    return d;
  }
  Result<void> configure(const participant::RunInfo&) override { return {}; }
  Result<participant::InterfaceMesh> initialize() override {
    participant::InterfaceMesh mesh;
    mesh.points = {0, 0, 0, 1, 0, 0};
    mesh.lines = {0, 1};
    mesh.mesh_node_count = nodes_;
    return mesh;
  }
  Result<void> begin_step(const participant::StepInfo&) override { return {}; }
  Result<participant::IterationReport> iterate(const participant::Fields&, participant::Fields&) override {
    return participant::IterationReport{};
  }
  Result<void> commit(bool) override { return {}; }
  Result<void> rollback() override { return {}; }
  Result<void> checkpoint(const fs::path&) override { return {}; }
  Result<void> restore(const fs::path&) override { return {}; }

 private:
  std::uint64_t nodes_;
};

/// The coupler's side of one participant, which is forked off.
class Line {
 public:
  Line(const std::string& address, std::uint64_t nodes) {
    int endpoint[2];
    if (pipe(endpoint) != 0) std::abort();
    child_ = fork();
    if (child_ == 0) std::_Exit(serve(endpoint[0], nodes));
    router_ = zmq::socket_t(context_, zmq::socket_type::router);
    wire::prepare(router_);
    if (address.rfind("ipc://", 0) == 0) { // as launcher::Hub does
      router_.set(zmq::sockopt::sndbuf, 4 << 20);
      router_.set(zmq::sockopt::rcvbuf, 4 << 20);
    }
    router_.bind(address);
    const std::string bound = router_.get(zmq::sockopt::last_endpoint);
    if (write(endpoint[1], bound.data(), bound.size()) < 0) std::abort();
    close(endpoint[0]);
    close(endpoint[1]);
    (void)receive();
    ask([](v1::Envelope& e) { e.mutable_configure()->set_version(wire::version); });
    ask([](v1::Envelope& e) { e.mutable_initialize(); });
    ask([](v1::Envelope& e) { e.mutable_begin_step()->set_time_step(1); });
  }
  ~Line() {
    ask([](v1::Envelope& e) { e.mutable_shutdown(); });
    waitpid(child_, nullptr, 0);
  }
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;

  template <class Fill>
  wire::Message request(Fill&& fill) {
    wire::Message m;
    m.envelope.set_run_id("bench");
    m.envelope.set_request_id(++number_);
    fill(m.envelope);
    return m;
  }
  template <class Fill>
  void ask(Fill&& fill) {
    exchange(request(fill));
  }
  void exchange(wire::Message message) {
    if (!wire::send(router_, "structure", std::move(message), std::chrono::seconds(60))) std::abort();
    if (receive().envelope.has_error()) std::abort();
  }

 private:
  static int serve(int pipe, std::uint64_t nodes) {
    char endpoint[256] = {};
    if (read(pipe, endpoint, sizeof endpoint - 1) <= 0) return 1;
    Sink sink(nodes);
    participant::ServeOptions options;
    options.endpoint = endpoint;
    options.participant = "structure";
    options.run_id = "bench";
    return participant::serve(sink, options) ? 0 : 1;
  }
  wire::Message receive() {
    while (true) {
      zmq::pollitem_t item{router_.handle(), 0, ZMQ_POLLIN, 0};
      zmq::poll(&item, 1, std::chrono::seconds(60));
      auto got = wire::receive(router_, true);
      if (!got || !*got) std::abort();
      if (!(**got).message.envelope.has_beat()) return std::move((**got).message);
    }
  }
  zmq::context_t context_;
  zmq::socket_t router_;
  pid_t child_ = 0;
  std::uint64_t number_ = 0;
};

void iterate(v1::Envelope& e) {
  e.mutable_iterate();
}

void measure_line(const std::string& name, const std::string& address) {
  double round_trip = 0;
  {
    Line line(address, 0);
    for (int i = 0; i < 200; ++i) line.ask(iterate);
    round_trip = seconds([&] {
                   for (int i = 0; i < round_trips; ++i) line.ask(iterate);
                 }) /
                 round_trips;
    row(name + "/round_trip_of_an_empty_iterate", round_trips, 1e6 * round_trip, "us");
  }
  Line line(address, large_nodes);
  double least = INFINITY;
  for (int i = 0; i < crossings; ++i) {
    wire::Message m = line.request(iterate);
    m.floats["force"] = {{large_nodes, 3}, std::vector<double>(3 * large_nodes, 0.5)};
    least = std::min(least, seconds([&] { line.exchange(std::move(m)); }));
  }
  const double gigabytes = 3 * 8 * static_cast<double>(large_nodes) / 1e9;
  row(name + "/crossing_of_100_MB", crossings, gigabytes / (least - round_trip), "GB/s");
}

io::State state_of(const char* kind, std::uint64_t nodes,
                   std::initializer_list<std::pair<const char*, std::uint64_t>> fields) {
  io::State state{kind, "0123456789abcdef", 1.0, 1, {}};
  for (const auto& [name, components] : fields)
    state.add(name, {nodes, components}, std::vector<double>(nodes * components, 1.0 / 3));
  return state;
}

void measure_checkpoint() {
  std::string folder = (fs::temp_directory_path() / "drogue-bench-XXXXXX").string();
  if (!mkdtemp(folder.data())) return;
  const io::State fluid = state_of("fluid", 133'097,
                                   {{"velocity", 3},
                                    {"pressure", 1},
                                    {"kinematic_pressure", 1},
                                    {"wall_velocity", 3},
                                    {"position", 3},
                                    {"velocity_before", 3}}),
                  mover = state_of("mesh", 133'097, {{"displacement", 3}, {"increment", 3}}),
                  structure = state_of(
                      "structure", 9'183,
                      {{"displacement", 3}, {"velocity", 3}, {"acceleration", 3}, {"interface_force", 3}}),
                  coupler = state_of("coupler", 9'183, {{"levels", 18}, {"secants", 2 * 3 * 100}});
  const coupler::CheckpointStore store(folder);
  std::uint64_t step = 0;
  bool written = true;
  const double least_time = least(5, [&] {
    const auto at = store.begin(++step);
    written = written && at.ok() && io::write_state(*at / "fluid/fluid.state", fluid).ok() &&
              io::write_state(*at / "mesh_mover/mesh.state", mover).ok() &&
              io::write_state(*at / "structure/structure.state", structure).ok() &&
              io::write_state(*at / "coupler.state", coupler).ok() &&
              store.complete({step, 1.0, {folder, "x"}, {}}).ok();
    store.prune(1);
  });
  fs::remove_all(folder);
  if (require(written, "the checkpoint could not be written"))
    row("checkpoint_at_the_papers_size", 5, least_time, "s");
}

} // namespace
} // namespace drogue

int main() {
  spdlog::set_level(spdlog::level::warn);
  std::string folder = (std::filesystem::temp_directory_path() / "drogue-bench-XXXXXX").string();
  if (!mkdtemp(folder.data())) return 1;
  drogue::measure_line("ipc", "ipc://" + folder + "/coupler");
  drogue::measure_line("tcp", "tcp://127.0.0.1:*");
  drogue::measure_checkpoint();
  std::filesystem::remove_all(folder);
  return 0;
}
