// SPDX-License-Identifier: GPL-3.0-or-later
// A scripted coupler against the SDK: every promise of the protocol's participant side.
#include "participant/cpp/participant.hpp"

#include <cmath>
#include <csignal>
#include <filesystem>
#include <future>
#include <thread>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "participant/cpp/protocol_state.hpp"
#include "participant/cpp/wire.hpp"

namespace drogue::participant {
namespace {

using namespace std::chrono_literals;
using v1::FieldContract;

/// Doubles what it gets; two interface nodes.
class Doubler : public Solver {
 public:
  Description describe() override {
    Description d;
    d.software = "doubler";
    d.can_replace_mesh = replaces;
    d.inputs = {field("force", FieldContract::FORCE, FieldContract::INTERFACE_NODES, 3)};
    d.outputs = {field("displacement", FieldContract::DISPLACEMENT, FieldContract::INTERFACE_NODES, 3)};
    return d;
  }
  Result<void> configure(const RunInfo&) override { return {}; }
  Result<InterfaceMesh> initialize() override {
    InterfaceMesh mesh;
    mesh.points = {0, 0, 0, 1, 0, 0};
    mesh.mesh_node_count = 2;
    return mesh;
  }
  Result<void> begin_step(const StepInfo&) override { return {}; }
  Result<IterationReport> iterate(const Fields& in, Fields& out) override {
    ++iterations;
    if (work > 0s) std::this_thread::sleep_for(work);
    FloatArray a = in.at("force");
    for (double& v : a.values) v *= 2;
    if (a.values[0] > 100) return retryable_error("too much force");
    if (a.values[1] > 100) a.values[1] = NAN;
    out["displacement"] = a;
    return IterationReport{1, 0.5, true};
  }
  Result<void> commit(bool) override { return {}; }
  std::optional<NewMesh> new_mesh() override { return offered; }
  Result<ReplacedMesh> replace_mesh(const NewMesh& mesh, bool restoring) override {
    if (mesh.mesh_hash != "def") return config_error("{} is not the mesh", mesh.file.string());
    return ReplacedMesh{{restoring ? 8 : 7, 9}, 10, "def", 0.1, 0.2, 0.3};
  }
  Result<void> rollback() override { return {}; }
  Result<void> checkpoint(const std::filesystem::path&) override { return {}; }
  Result<void> restore(const std::filesystem::path&) override { return {}; }

  std::atomic<int> iterations = 0;
  std::chrono::milliseconds work{0};
  bool replaces = false;
  std::optional<NewMesh> offered;
};

class ScriptedPeer : public testing::Test {
 protected:
  void SetUp() override {
    router_ = zmq::socket_t(context_, zmq::socket_type::router);
    wire::prepare(router_);
    router_.bind("tcp://127.0.0.1:*");
    ServeOptions options{router_.get(zmq::sockopt::last_endpoint), "structure", "run-1", 20s};
    outcome_ = std::async(std::launch::async, [this, options] { return serve(solver_, options); });
  }
  void TearDown() override {
    if (outcome_.valid() && outcome_.wait_for(0s) != std::future_status::ready) {
      request([](v1::Envelope& e) { e.mutable_shutdown(); });
      outcome_.wait();
    }
  }

  wire::Message receive(bool skip_beats = true) {
    const auto end = std::chrono::steady_clock::now() + 10s;
    while (std::chrono::steady_clock::now() < end) {
      auto received = wire::receive(router_, true);
      if (!received) {
        ADD_FAILURE() << received.error().message;
        return {};
      }
      if (*received) {
        wire::Message m = std::move((**received).message);
        if (!skip_beats || m.envelope.body_case() != v1::Envelope::kBeat) return m;
      }
      std::this_thread::sleep_for(1ms);
    }
    ADD_FAILURE() << "no answer";
    return {};
  }

  void send(wire::Message m) { ASSERT_TRUE(wire::send(router_, "structure", m, 1s).ok()); }

  template <class Fill>
  wire::Message message(Fill&& fill) {
    wire::Message m;
    m.envelope.set_run_id("run-1");
    m.envelope.set_request_id(++id_);
    fill(m.envelope);
    return m;
  }
  template <class Fill>
  wire::Message request(Fill&& fill) {
    send(message(fill));
    return receive();
  }
  wire::Message iterate(std::vector<double> force, std::vector<std::uint64_t> shape = {2, 3}) {
    wire::Message m = message([](v1::Envelope& e) { e.mutable_iterate(); });
    m.floats["force"] = {std::move(shape), std::move(force)};
    send(m);
    return receive();
  }
  void bring_to_ready() {
    EXPECT_TRUE(receive().envelope.has_hello());
    EXPECT_TRUE(request([](v1::Envelope& e) { e.mutable_configure()->set_version(1); }).envelope.has_done());
    EXPECT_TRUE(request([](v1::Envelope& e) { e.mutable_initialize(); }).envelope.has_initialized());
  }
  void begin_step() {
    EXPECT_TRUE(
        request([](v1::Envelope& e) { e.mutable_begin_step()->set_time_step(0.1); }).envelope.has_done());
  }

  zmq::context_t context_;
  zmq::socket_t router_;
  Doubler solver_;
  std::future<Result<void>> outcome_;
  std::uint64_t id_ = 0;
};

TEST_F(ScriptedPeer, RunsAStepAndShutsDown) {
  bring_to_ready();
  begin_step();
  const wire::Message answer = iterate({1, 2, 3, 4, 5, 6});
  ASSERT_TRUE(answer.envelope.has_iterated()) << answer.envelope.DebugString();
  EXPECT_EQ(answer.floats.at("displacement").values, (std::vector<double>{2, 4, 6, 8, 10, 12}));
  EXPECT_TRUE(request([](v1::Envelope& e) { e.mutable_commit(); }).envelope.has_done());
  EXPECT_TRUE(request([](v1::Envelope& e) { e.mutable_shutdown(); }).envelope.has_done());
  EXPECT_TRUE(outcome_.get().ok());
}

TEST_F(ScriptedPeer, RefusesRequestsThatDoNotFitTheState) {
  bring_to_ready();
  const wire::Message early = request([](v1::Envelope& e) { e.mutable_commit(); });
  EXPECT_EQ(early.envelope.error().code(), v1::Error::WRONG_STATE);
  EXPECT_EQ(early.envelope.error().message(), "Commit is not allowed in state READY");
  begin_step();
  EXPECT_EQ(request([](v1::Envelope& e) { e.mutable_commit(); }).envelope.error().code(),
            v1::Error::WRONG_STATE);
  EXPECT_TRUE(iterate({0, 0, 0, 0, 0, 0}).envelope.has_iterated()); // it goes on as if nothing had been asked
}

/// A participant that can replace its mesh, and offers one.
class ReplacingPeer : public ScriptedPeer {
 protected:
  void SetUp() override {
    solver_.replaces = true;
    solver_.offered = NewMesh{"/tmp/new.msh", "def", "worn"};
    ScriptedPeer::SetUp();
  }
  wire::Message replace(const std::string& hash, bool restoring) {
    return request([&](v1::Envelope& e) {
      e.mutable_replace_mesh()->set_file("/tmp/new.msh");
      e.mutable_replace_mesh()->set_mesh_hash(hash);
      e.mutable_replace_mesh()->set_restoring(restoring);
    });
  }
};

TEST_F(ReplacingPeer, OffersAMeshWithItsCommitAndGoesOverToIt) {
  const wire::Message said = receive();
  EXPECT_TRUE(said.envelope.hello().can_replace_mesh());
  request([](v1::Envelope& e) { e.mutable_configure()->set_version(1); });
  request([](v1::Envelope& e) { e.mutable_initialize(); });
  begin_step();
  EXPECT_EQ(replace("def", false).envelope.error().code(), v1::Error::WRONG_STATE);
  iterate({0, 0, 0, 0, 0, 0});
  const wire::Message done = request([](v1::Envelope& e) { e.mutable_commit(); });
  EXPECT_EQ(done.envelope.done().new_mesh().file(), "/tmp/new.msh");
  EXPECT_EQ(done.envelope.done().new_mesh().mesh_hash(), "def");
  EXPECT_EQ(done.envelope.done().new_mesh().reason(), "worn");
  const wire::Message replaced = replace("def", false);
  EXPECT_EQ(replaced.envelope.replaced().mesh_node_count(), 10u);
  EXPECT_EQ(replaced.envelope.replaced().mesh_hash(), "def");
  EXPECT_EQ(replaced.envelope.replaced().mass_defect(), 0.1);
  EXPECT_EQ(replaced.envelope.replaced().momentum_defect(), 0.2);
  EXPECT_EQ(replaced.envelope.replaced().energy_defect(), 0.3);
  EXPECT_EQ(replaced.indices.at("mesh_nodes").values, (std::vector<std::int64_t>{7, 9}));
  EXPECT_EQ(replace("def", true).indices.at("mesh_nodes").values[0], 8);
  begin_step();
  EXPECT_TRUE(iterate({0, 0, 0, 0, 0, 0}).envelope.has_iterated());
}

TEST_F(ReplacingPeer, AMeshThatItCannotTakeEndsIt) {
  bring_to_ready();
  EXPECT_EQ(replace("other", false).envelope.error().code(), v1::Error::CONFIGURATION);
  EXPECT_FALSE(outcome_.get().ok());
}

TEST_F(ScriptedPeer, RefusesAnotherMeshWhenItSaysSo) {
  bring_to_ready();
  const wire::Message refused = request([](v1::Envelope& e) { e.mutable_replace_mesh(); });
  EXPECT_EQ(refused.envelope.error().code(), v1::Error::UNSUPPORTED);
  EXPECT_FALSE(outcome_.get().ok());
}

TEST_F(ScriptedPeer, ChecksShapesNamesRunAndFiniteness) {
  bring_to_ready();
  begin_step();
  EXPECT_EQ(iterate({1, 2, 3}, {1, 3}).envelope.error().message(),
            "input \"force\" has shape {1, 3}, expected {2, 3}");
  const wire::Message missing = request([](v1::Envelope& e) { e.mutable_iterate(); });
  EXPECT_EQ(missing.envelope.error().message(), "input \"force\" is missing");
  EXPECT_EQ(iterate({0, 0, 0, 0, INFINITY, 0}).envelope.error().message(),
            "input \"force\" is not finite at node 1, component 1");
  const wire::Message other = request([](v1::Envelope& e) {
    e.set_run_id("other");
    e.mutable_iterate();
  });
  EXPECT_EQ(other.envelope.error().code(), v1::Error::BAD_MESSAGE);
  EXPECT_EQ(solver_.iterations, 0);
}

TEST_F(ScriptedPeer, ARetryableErrorAndAnOutputThatIsNotFiniteAllowRollback) {
  bring_to_ready();
  begin_step();
  const wire::Message refused = iterate({60, 0, 0, 0, 0, 0});
  EXPECT_TRUE(refused.envelope.error().retryable());
  EXPECT_EQ(refused.envelope.error().code(), v1::Error::NUMERICAL);
  EXPECT_TRUE(request([](v1::Envelope& e) { e.mutable_rollback(); }).envelope.has_done());
  begin_step();
  EXPECT_EQ(iterate({0, 60, 0, 0, 0, 0}).envelope.error().message(),
            "output \"displacement\" is not finite at node 0, component 1");
  EXPECT_TRUE(request([](v1::Envelope& e) { e.mutable_rollback(); }).envelope.has_done());
}

TEST_F(ScriptedPeer, ARepeatedRequestGetsTheCachedAnswer) {
  bring_to_ready();
  begin_step();
  const wire::Message first = iterate({1, 0, 0, 0, 0, 0});
  --id_;
  const wire::Message again = iterate({1, 0, 0, 0, 0, 0});
  EXPECT_EQ(again.envelope.request_id(), first.envelope.request_id());
  EXPECT_EQ(again.floats.at("displacement").values, first.floats.at("displacement").values);
  EXPECT_EQ(solver_.iterations, 1);
}

TEST_F(ScriptedPeer, BeatsWhileItWorks) {
  bring_to_ready();
  begin_step();
  solver_.work = 1700ms;
  wire::Message m = message([](v1::Envelope& e) { e.mutable_iterate(); });
  m.floats["force"] = {{2, 3}, {1, 0, 0, 0, 0, 0}};
  send(m);
  EXPECT_TRUE(receive(false).envelope.has_beat());
  EXPECT_TRUE(receive().envelope.has_iterated());
}

/// Waiting costs nothing: its threads wake a few times a second, whether the solver works or not.
TEST_F(ScriptedPeer, SleepsWhileItWaits) {
  bring_to_ready();
  begin_step();
  const auto switches = [] {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_nvcsw;
  };
  const long before = switches();
  std::this_thread::sleep_for(1500ms);
  EXPECT_LT(switches() - before, 300);
  solver_.work = 1500ms;
  wire::Message m = message([](v1::Envelope& e) { e.mutable_iterate(); });
  m.floats["force"] = {{2, 3}, {1, 0, 0, 0, 0, 0}};
  send(m);
  const long at_work = switches();
  std::this_thread::sleep_for(1200ms);
  EXPECT_LT(switches() - at_work, 300);
  EXPECT_TRUE(receive().envelope.has_iterated());
}

TEST_F(ScriptedPeer, ASignalDoesNotEndItsWait) {
  bring_to_ready();
  struct sigaction ignore {};
  ignore.sa_handler = [](int) {}; // without SA_RESTART: every wait that it meets is interrupted
  ASSERT_EQ(sigaction(SIGUSR1, &ignore, nullptr), 0);
  for (int k = 0; k < 20; ++k) {
    for (const auto& task : std::filesystem::directory_iterator("/proc/self/task"))
      if (const int thread = std::stoi(task.path().filename()); thread != getpid())
        (void)syscall(SYS_tgkill, getpid(), thread, SIGUSR1);
    std::this_thread::sleep_for(5ms);
  }
  begin_step();
  EXPECT_TRUE(iterate({1, 2, 3, 4, 5, 6}).envelope.has_iterated());
}

TEST_F(ScriptedPeer, ACorruptArrayEndsTheParticipant) {
  bring_to_ready();
  begin_step();
  wire::Message m = message([](v1::Envelope& e) { e.mutable_iterate(); });
  v1::ArrayHeader& header = *m.envelope.add_array();
  header.set_name("force");
  header.set_type(v1::ArrayHeader::FLOAT64);
  header.add_shape(1);
  header.set_byte_length(8);
  header.set_crc32(1234);
  const std::string body = m.envelope.SerializeAsString();
  const double value = 1;
  router_.send(zmq::str_buffer("structure"), zmq::send_flags::sndmore);
  router_.send(zmq::const_buffer("DRGW\x01", 5), zmq::send_flags::sndmore);
  router_.send(zmq::buffer(body), zmq::send_flags::sndmore);
  router_.send(zmq::const_buffer(&value, 8), zmq::send_flags::none);
  const auto outcome = outcome_.get();
  ASSERT_FALSE(outcome.ok());
  EXPECT_NE(outcome.error().message.find("checksum"), std::string::npos) << outcome.error().message;
}

TEST_F(ScriptedPeer, NoticesThatTheCouplerIsGone) {
  bring_to_ready();
  router_.close();
  const auto outcome = outcome_.get();
  ASSERT_FALSE(outcome.ok());
  EXPECT_EQ(outcome.error().kind, ErrorKind::peer);
}

TEST_F(ScriptedPeer, AbortEndsItWithThePeerStatus) {
  bring_to_ready();
  EXPECT_TRUE(
      request([](v1::Envelope& e) { e.mutable_abort()->set_reason("fluid died"); }).envelope.has_done());
  const auto outcome = outcome_.get();
  ASSERT_FALSE(outcome.ok());
  EXPECT_EQ(exit_status(outcome.error()), 4);
  EXPECT_NE(outcome.error().message.find("fluid died"), std::string::npos);
}

TEST(Serve, GivesUpOnASilentCoupler) {
  zmq::context_t context;
  zmq::socket_t router(context, zmq::socket_type::router);
  router.bind("tcp://127.0.0.1:*");
  Doubler solver;
  const auto outcome = serve(solver, {router.get(zmq::sockopt::last_endpoint), "structure", "run-1", 1s});
  ASSERT_FALSE(outcome.ok());
  EXPECT_EQ(outcome.error().kind, ErrorKind::peer);
  EXPECT_NE(outcome.error().message.find("sent nothing for 1 s"), std::string::npos)
      << outcome.error().message;
}

} // namespace
} // namespace drogue::participant
