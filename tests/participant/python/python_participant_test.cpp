// SPDX-License-Identifier: GPL-3.0-or-later
// A scripted coupler, written with the C++ side of the wire, against participants written in Python.
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <thread>

#include <gtest/gtest.h>

#include "common/mesh/msh.hpp"
#include "mesh_mover/mesh_participant.hpp"
#include "participant/cpp/wire.hpp"
#include "tests/mesh_mover/box_mesh.hpp"

namespace drogue {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

/// A Python program and the coupler's end of its connection.
class PythonPeer : public testing::Test {
 protected:
  void start(const std::string& script, std::vector<std::string> arguments, const std::string& participant) {
    participant_ = participant;
    router_ = zmq::socket_t(context_, zmq::socket_type::router);
    wire::prepare(router_);
    router_.bind("tcp://127.0.0.1:*");
    arguments.push_back(router_.get(zmq::sockopt::last_endpoint));
    std::vector<char*> argv;
    std::string python = DROGUE_PYTHON;
    std::string file = script;
    argv.push_back(python.data());
    argv.push_back(file.data());
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    pid_ = fork();
    ASSERT_GE(pid_, 0);
    if (pid_ != 0) return;
    setenv("PYTHONPATH", DROGUE_PYTHON_DIR, 1);
    setenv("DROGUE_RUN_ID", "run-1", 1);
    setenv("DROGUE_PARTICIPANT", participant.c_str(), 1);
    execv(argv[0], argv.data());
    _exit(127);
  }
  void TearDown() override {
    if (pid_ > 0) kill(pid_, SIGKILL);
    if (pid_ > 0) waitpid(pid_, nullptr, 0);
  }
  /// Exit status of the program, which must end by itself; -1 when it does not.
  int wait_for_exit(std::chrono::seconds deadline = 20s) {
    const auto end = Clock::now() + deadline;
    while (Clock::now() < end) {
      int status = 0;
      if (waitpid(pid_, &status, WNOHANG) == pid_) {
        pid_ = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
      }
      std::this_thread::sleep_for(5ms);
    }
    return -1;
  }
  wire::Message receive(bool skip_beats = true) {
    const auto end = Clock::now() + 60s;
    while (Clock::now() < end) {
      auto received = wire::receive(router_, true);
      if (!received) {
        ADD_FAILURE() << received.error().message;
        return {};
      }
      if (*received && (!skip_beats || !(**received).message.envelope.has_beat()))
        return std::move((**received).message);
      std::this_thread::sleep_for(1ms);
    }
    ADD_FAILURE() << "no answer";
    return {};
  }
  template <class Fill>
  wire::Message request(Fill&& fill, participant::Fields fields = {}, bool skip_beats = true) {
    wire::Message m;
    m.envelope.set_run_id("run-1");
    m.envelope.set_request_id(++id_);
    fill(m.envelope);
    m.floats = std::move(fields);
    EXPECT_TRUE(wire::send(router_, participant_, m, 1s).ok());
    return receive(skip_beats);
  }
  wire::Message iterate(participant::Fields fields, bool skip_beats = true) {
    return request([](v1::Envelope& e) { e.mutable_iterate(); }, std::move(fields), skip_beats);
  }
  wire::Message iterate_doubler(double first, bool skip_beats = true) {
    return iterate({{"force", {{2, 3}, {first, 0, 0, 0, 0, 8}}}}, skip_beats);
  }
  v1::Hello hello() {
    const wire::Message m = receive();
    EXPECT_TRUE(m.envelope.has_hello());
    EXPECT_EQ(m.envelope.run_id(), "run-1");
    EXPECT_EQ(m.envelope.participant(), participant_);
    return m.envelope.hello();
  }
  wire::Message initialize() {
    EXPECT_TRUE(request([](v1::Envelope& e) { e.mutable_configure()->set_version(1); }).envelope.has_done());
    wire::Message m = request([](v1::Envelope& e) { e.mutable_initialize(); });
    EXPECT_TRUE(m.envelope.has_initialized()) << m.envelope.DebugString();
    return m;
  }
  void begin_step() {
    EXPECT_TRUE(
        request([](v1::Envelope& e) { e.mutable_begin_step()->set_time_step(0.1); }).envelope.has_done());
  }
  void rollback() {
    EXPECT_TRUE(request([](v1::Envelope& e) { e.mutable_rollback(); }).envelope.has_done());
  }
  void shut_down() {
    EXPECT_TRUE(request([](v1::Envelope& e) { e.mutable_shutdown(); }).envelope.has_done());
    EXPECT_EQ(wait_for_exit(), 0);
  }
  void start_doubler() {
    start(DROGUE_SOURCE_DIR "/tests/participant/python/doubler.py", {}, "structure");
    const v1::Hello h = hello();
    EXPECT_EQ(h.software(), "doubler.py");
    EXPECT_EQ(h.pid(0), pid_);
    EXPECT_EQ(h.input(0).name(), "force");
    EXPECT_EQ(h.output(0).quantity(), v1::FieldContract::DISPLACEMENT);
    const wire::Message m = initialize();
    EXPECT_EQ(m.envelope.initialized().mesh_hash(), "abc");
    EXPECT_EQ(m.floats.at("points").values, (std::vector<double>{0, 0, 0, 1, 0, 0}));
    EXPECT_EQ(m.indices.at("lines").shape, (std::vector<std::uint64_t>{1, 2}));
    EXPECT_EQ(m.indices.at("lines").values, (std::vector<std::int64_t>{1, 0}));
  }

  zmq::context_t context_;
  zmq::socket_t router_;
  std::string participant_;
  pid_t pid_ = -1;
  std::uint64_t id_ = 0;
};

TEST_F(PythonPeer, RunsStepsAndShutsDown) {
  start_doubler();
  begin_step();
  const wire::Message answer = iterate_doubler(0);
  ASSERT_TRUE(answer.envelope.has_iterated()) << answer.envelope.DebugString();
  EXPECT_EQ(answer.envelope.request_id(), id_);
  EXPECT_EQ(answer.envelope.iterated().inner_residual(), 0.5);
  EXPECT_EQ(answer.floats.at("displacement").shape, (std::vector<std::uint64_t>{2, 3}));
  EXPECT_EQ(answer.floats.at("displacement").values.back(), 16);
  EXPECT_TRUE(request([](v1::Envelope& e) { e.mutable_commit(); }).envelope.has_done());
  shut_down();
}

TEST_F(PythonPeer, OffersAMeshWithItsCommitAndGoesOverToIt) {
  start_doubler();
  begin_step();
  (void)iterate_doubler(0);
  const wire::Message done = request([](v1::Envelope& e) { e.mutable_commit(); });
  EXPECT_EQ(done.envelope.done().new_mesh().file(), "/tmp/new.msh");
  EXPECT_EQ(done.envelope.done().new_mesh().mesh_hash(), "def");
  EXPECT_EQ(done.envelope.done().new_mesh().reason(), "worn");
  const auto replace = [&](bool restoring) {
    return request([&](v1::Envelope& e) {
      e.mutable_replace_mesh()->set_mesh_hash("def");
      e.mutable_replace_mesh()->set_restoring(restoring);
    });
  };
  const wire::Message replaced = replace(false);
  EXPECT_EQ(replaced.envelope.replaced().mesh_node_count(), 10u);
  EXPECT_EQ(replaced.envelope.replaced().mesh_hash(), "def");
  EXPECT_EQ(replaced.envelope.replaced().momentum_defect(), 0.2);
  EXPECT_EQ(replaced.indices.at("mesh_nodes").values, (std::vector<std::int64_t>{7, 9}));
  EXPECT_EQ(replace(true).indices.at("mesh_nodes").values[0], 8);
  begin_step();
  (void)iterate_doubler(0);
  EXPECT_FALSE(request([](v1::Envelope& e) { e.mutable_commit(); }).envelope.done().has_new_mesh());
  shut_down();
}

TEST_F(PythonPeer, RefusesWhatDoesNotFitAndGoesOn) {
  start_doubler();
  const wire::Message early = request([](v1::Envelope& e) { e.mutable_commit(); });
  EXPECT_EQ(early.envelope.error().code(), v1::Error::WRONG_STATE);
  EXPECT_EQ(early.envelope.error().message(), "Commit is not allowed in state READY");
  EXPECT_EQ(request([](v1::Envelope& e) { e.mutable_checkpoint(); }).envelope.error().message(),
            "this participant cannot checkpoint");
  EXPECT_EQ(wait_for_exit(), 2);
}

TEST_F(PythonPeer, ChecksInputs) {
  start_doubler();
  begin_step();
  EXPECT_EQ(iterate({}).envelope.error().message(), "input \"force\" is missing");
  EXPECT_EQ(iterate({{"force", {{1, 3}, {0, 0, 0}}}}).envelope.error().message(),
            "input \"force\" has shape {1, 3}, expected {2, 3}");
  const wire::Message bad = iterate({{"force", {{2, 3}, {0, 0, 0, 0, INFINITY, 0}}}});
  EXPECT_EQ(bad.envelope.error().code(), v1::Error::NOT_FINITE);
  EXPECT_EQ(bad.envelope.error().message(), "input \"force\" is not finite at node 1, component 1");
  const wire::Message other = request([](v1::Envelope& e) {
    e.set_run_id("other");
    e.mutable_iterate();
  });
  EXPECT_EQ(other.envelope.error().message(), "run \"run-1\" expected, got \"other\"");
  EXPECT_EQ(iterate_doubler(0).envelope.iterated().inner_iterations(), 1U); // the solver saw none of these
  shut_down();
}

TEST_F(PythonPeer, ARetryableErrorAndANotFiniteOutputAllowRollback) {
  start_doubler();
  begin_step();
  const wire::Message refused = iterate_doubler(1);
  EXPECT_EQ(refused.envelope.error().code(), v1::Error::NUMERICAL);
  EXPECT_TRUE(refused.envelope.error().retryable());
  EXPECT_EQ(refused.envelope.error().message(), "too much force");
  rollback();
  begin_step();
  const wire::Message nan = iterate_doubler(2);
  EXPECT_EQ(nan.envelope.error().message(), "output \"displacement\" is not finite at node 0, component 0");
  EXPECT_TRUE(nan.envelope.error().retryable());
  rollback();
  begin_step();
  EXPECT_TRUE(iterate_doubler(0).envelope.has_iterated());
  shut_down();
}

TEST_F(PythonPeer, AnswersARepeatedRequestFromItsCacheAndBeats) {
  start_doubler();
  begin_step();
  const wire::Message beat = iterate_doubler(3, false);
  ASSERT_TRUE(beat.envelope.has_beat()) << beat.envelope.DebugString();
  EXPECT_EQ(beat.envelope.beat().phase(), "sleeping");
  EXPECT_EQ(beat.envelope.beat().inner_iteration(), 7U);
  const wire::Message first = receive();
  ASSERT_TRUE(first.envelope.has_iterated());
  --id_;
  const wire::Message again = iterate_doubler(3);
  EXPECT_EQ(again.envelope.request_id(), first.envelope.request_id());
  EXPECT_EQ(again.envelope.iterated().inner_iterations(), 1U);
  EXPECT_EQ(again.floats.at("displacement").values, first.floats.at("displacement").values);
  shut_down();
}

TEST_F(PythonPeer, ABugInTheSolverReachesTheCoupler) {
  start_doubler();
  begin_step();
  const wire::Message broken = iterate_doubler(4);
  EXPECT_EQ(broken.envelope.error().code(), v1::Error::INTERNAL);
  EXPECT_FALSE(broken.envelope.error().retryable());
  EXPECT_EQ(broken.envelope.error().message(), "ValueError: a bug");
  EXPECT_EQ(wait_for_exit(), 1);
}

TEST_F(PythonPeer, AFailureOfItsConnectionEndsIt) {
  start_doubler();
  begin_step();
  wire::Message m;
  m.envelope.set_run_id("run-1");
  m.envelope.set_request_id(++id_);
  m.envelope.mutable_iterate();
  m.floats["force"] = {{2, 3}, {6, 0, 0, 0, 0, 0}};
  EXPECT_TRUE(wire::send(router_, participant_, m, 1s).ok());
  EXPECT_EQ(wait_for_exit(), 1);
}

TEST_F(PythonPeer, AnOutputOfTheWrongShapeEndsIt) {
  start_doubler();
  begin_step();
  EXPECT_EQ(iterate_doubler(5).envelope.error().message(),
            "output \"displacement\" has shape {5, 3}, expected {2, 3}");
  EXPECT_EQ(wait_for_exit(), 3);
}

TEST_F(PythonPeer, AbortEndsItWithThePeerStatus) {
  start_doubler();
  EXPECT_TRUE(
      request([](v1::Envelope& e) { e.mutable_abort()->set_reason("fluid died"); }).envelope.has_done());
  EXPECT_EQ(wait_for_exit(), 4);
}

TEST_F(PythonPeer, NoticesThatTheCouplerIsGone) {
  start_doubler();
  router_.close();
  EXPECT_EQ(wait_for_exit(), 4);
}

TEST_F(PythonPeer, ACorruptArrayEndsIt) {
  start_doubler();
  begin_step();
  v1::Envelope envelope;
  envelope.set_run_id("run-1");
  envelope.set_request_id(++id_);
  envelope.mutable_iterate();
  v1::ArrayHeader& header = *envelope.add_array();
  header.set_name("force");
  header.set_type(v1::ArrayHeader::FLOAT64);
  header.add_shape(1);
  header.set_byte_length(8);
  header.set_crc32(1234);
  const std::string body = envelope.SerializeAsString();
  const double value = 1;
  router_.send(zmq::buffer(participant_), zmq::send_flags::sndmore);
  router_.send(zmq::const_buffer("DRGW\x01", 5), zmq::send_flags::sndmore);
  router_.send(zmq::buffer(body), zmq::send_flags::sndmore);
  router_.send(zmq::const_buffer(&value, 8), zmq::send_flags::none);
  EXPECT_EQ(wait_for_exit(), 4);
}

/// The Python mesh mover beside the C++ one, on one mesh.
class PythonMeshMover : public PythonPeer {
 protected:
  void SetUp() override {
    const auto axis = test::graded(1, 4, 1.5);
    auto mesh = test::box_mesh({axis, axis, axis}, [](int i, int j, int k) {
      const auto inside = [](int a) { return a == 3 || a == 4; };
      return inside(i) && inside(j) && inside(k);
    });
    folder_ = std::filesystem::temp_directory_path() / fmt::format("drogue_python_{}", getpid());
    std::filesystem::create_directories(folder_);
    file_ = folder_ / "box.msh";
    ASSERT_TRUE(mesh::write_msh(file_, mesh).ok());
    auto read = mesh::read_msh(file_);
    ASSERT_TRUE(read.ok());
    mesh_ = std::move(*read);
    start(DROGUE_SOURCE_DIR "/examples/python_mesh_mover/mesh_mover.py",
          {"--mesh", file_.string(), "--interface", "body", "--connect"}, "mesh_mover");
    hello();
    initialized_ = initialize();
  }
  void TearDown() override {
    PythonPeer::TearDown();
    std::filesystem::remove_all(folder_);
  }
  wire::Message move(double shift, double translation) {
    const auto n = initialized_.floats.at("points").shape[0];
    std::vector<double> d(3 * n, shift);
    return iterate(
        {{"displacement", {{n, 3}, d}}, {"translation", {{1, 3}, std::vector<double>(3, translation)}}});
  }

  std::filesystem::path folder_, file_;
  mesh::Mesh mesh_;
  wire::Message initialized_;
};

TEST_F(PythonMeshMover, ShowsTheSameMeshAndInterfaceAsOurs) {
  mesh_mover::Case input;
  for (const std::string side : {"x0", "x1", "y0", "y1", "z0", "z1", "body"}) {
    mesh_mover::Boundary boundary;
    boundary.name = side;
    boundary.is_interface = side == "body";
    boundary.condition =
        boundary.is_interface ? mesh_mover::Condition::displacement : mesh_mover::Condition::translated;
    input.settings.boundaries.push_back(boundary);
  }
  input.mesh = mesh_;
  mesh_mover::MeshParticipant ours(std::move(input));
  ASSERT_TRUE(ours.configure({folder_, 0, 0.1}).ok());
  const auto interface = ours.initialize();
  ASSERT_TRUE(interface.ok()) << interface.error().message;
  EXPECT_EQ(initialized_.envelope.initialized().mesh_hash(), interface->mesh_hash);
  EXPECT_EQ(initialized_.envelope.initialized().mesh_node_count(), interface->mesh_node_count);
  EXPECT_EQ(initialized_.floats.at("points").values, interface->points);
  EXPECT_EQ(initialized_.indices.at("triangles").values, interface->triangles);
  EXPECT_EQ(initialized_.indices.at("mesh_nodes").values, interface->mesh_nodes);
  shut_down();
}

TEST_F(PythonMeshMover, MovesTheMesh) {
  begin_step();
  const wire::Message answer = move(0.05, 0.01);
  ASSERT_TRUE(answer.envelope.has_iterated()) << answer.envelope.DebugString();
  const auto& u = answer.floats.at("mesh_displacement").values;
  for (const std::int32_t node : mesh_.nodes_of("body"))
    EXPECT_EQ(u[3 * static_cast<std::size_t>(node)], 0.05);
  for (const std::int32_t node : mesh_.nodes_of("x0")) EXPECT_EQ(u[3 * static_cast<std::size_t>(node)], 0.01);
  const auto [low, high] = std::minmax_element(u.begin(), u.end());
  EXPECT_GE(*low, 0.01 - 1e-12);
  EXPECT_LE(*high, 0.05 + 1e-12);
  const auto& quality = answer.floats.at("quality").values;
  EXPECT_GT(quality[0], 0);
  EXPECT_LT(quality[0], 1);
  EXPECT_TRUE(request([](v1::Envelope& e) { e.mutable_commit(); }).envelope.has_done());
  begin_step();
  const wire::Message rigid = move(0.7, 0.7);
  EXPECT_NEAR(rigid.floats.at("quality").values[0], 1, 1e-9);
  shut_down();
}

TEST_F(PythonMeshMover, RefusesAnInvertedMesh) {
  begin_step();
  const wire::Message refused = move(1.5, 0);
  EXPECT_TRUE(refused.envelope.error().retryable());
  EXPECT_NE(refused.envelope.error().message().find("is inverted"), std::string::npos);
  rollback();
  begin_step();
  EXPECT_TRUE(move(0.02, 0).envelope.has_iterated());
  shut_down();
}

} // namespace
} // namespace drogue
