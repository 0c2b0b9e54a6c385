// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/launcher/process.hpp"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <set>
#include <sstream>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

namespace drogue::launcher {
namespace {

namespace fs = std::filesystem;

/// Parent and session of a process, from /proc/PID/stat; nothing when it is gone.
struct Kinship {
  pid_t parent = 0;
  pid_t session = 0;
};
std::optional<Kinship> kinship(pid_t pid) {
  std::ifstream stat(fmt::format("/proc/{}/stat", pid));
  std::string text;
  if (!std::getline(stat, text)) return std::nullopt;
  const std::size_t end = text.rfind(')'); // the name in parentheses may hold anything
  if (end == std::string::npos) return std::nullopt;
  std::istringstream rest(text.substr(end + 1));
  char state = 0;
  Kinship k;
  pid_t group = 0;
  rest >> state >> k.parent >> group >> k.session;
  return rest ? std::optional(k) : std::nullopt;
}

std::vector<pid_t> all_processes() {
  std::vector<pid_t> pids;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator("/proc", ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") == std::string::npos) pids.push_back(std::atoi(name.c_str()));
  }
  return pids;
}

/// The process, its descendants, and every process of its session (an orphaned MPI rank keeps the session).
std::set<pid_t> family(pid_t root) {
  std::set<pid_t> members{root};
  for (std::size_t before = 0; before != members.size();) {
    before = members.size();
    for (const pid_t pid : all_processes())
      if (const auto k = kinship(pid); k && (k->session == root || members.count(k->parent) != 0))
        members.insert(pid);
  }
  return members;
}

/// What the child does between fork and exec: async-signal-safe calls only.
[[noreturn]] void become(const Command& command, char* const* arguments, char* const* environment, int log,
                         int report) {
  setsid();
  prctl(PR_SET_PDEATHSIG, SIGKILL); // if the coupler itself is killed
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  if (chdir(command.directory.c_str()) == 0 && dup2(log, STDOUT_FILENO) >= 0 &&
      dup2(log, STDERR_FILENO) >= 0) {
    const int null = open("/dev/null", O_RDONLY);
    if (null >= 0) dup2(null, STDIN_FILENO);
    execve(arguments[0], arguments, environment);
  }
  const int reason = errno;
  (void)!write(report, &reason, sizeof reason);
  _exit(127);
}

std::vector<char*> pointers(std::vector<std::string>& strings) {
  std::vector<char*> p;
  for (std::string& s : strings) p.push_back(s.data());
  p.push_back(nullptr);
  return p;
}

/// The coupler's environment with `extra` replacing variables of the same name.
std::vector<std::string> merged_environment(const std::vector<std::string>& extra) {
  std::vector<std::string> all;
  const auto name = [](const std::string& e) { return e.substr(0, e.find('=')); };
  for (char** e = environ; *e; ++e) {
    bool replaced = false;
    for (const std::string& x : extra) replaced = replaced || name(x) == name(*e);
    if (!replaced) all.emplace_back(*e);
  }
  all.insert(all.end(), extra.begin(), extra.end());
  return all;
}

} // namespace

std::string Exit::text() const {
  if (signal != 0) return fmt::format("was killed by signal {} ({})", signal, strsignal(signal));
  return fmt::format("exited with status {}", status);
}

Result<Process> Process::start(const Command& command) {
  std::vector<std::string> arguments = command.arguments;
  std::vector<std::string> environment = merged_environment(command.environment);
  const std::vector<char*> argv = pointers(arguments), envp = pointers(environment);

  const int log = open(command.log_file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (log < 0)
    return config_error("cannot write the log {}: {}", command.log_file.string(), std::strerror(errno));
  int report[2];
  if (pipe2(report, O_CLOEXEC) != 0) {
    close(log);
    return internal_error("no pipe: {}", std::strerror(errno));
  }
  const pid_t pid = fork();
  if (pid == 0) become(command, argv.data(), envp.data(), log, report[1]);
  close(log);
  close(report[1]);
  int reason = 0;
  const bool failed =
      pid > 0 && read(report[0], &reason, sizeof reason) == static_cast<ssize_t>(sizeof reason);
  close(report[0]);
  if (pid < 0) return internal_error("cannot fork: {}", std::strerror(errno));
  Process process(pid, static_cast<int>(syscall(SYS_pidfd_open, pid, 0)));
  if (failed) return config_error("cannot start {}: {}", command.arguments[0], std::strerror(reason));
  if (process.pidfd_ < 0) return internal_error("no pidfd: {}", std::strerror(errno));
  return process;
}

Process::Process(Process&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)), pidfd_(std::exchange(other.pidfd_, -1)), exit_(other.exit_) {}

Process& Process::operator=(Process&& other) noexcept {
  std::swap(pid_, other.pid_);
  std::swap(pidfd_, other.pidfd_);
  std::swap(exit_, other.exit_);
  return *this;
}

Process::~Process() {
  if (pid_ > 0) kill_session();
  if (pidfd_ >= 0) close(pidfd_);
}

const std::optional<Exit>& Process::poll() {
  int status = 0;
  if (!exit_ && pid_ > 0 && waitpid(pid_, &status, WNOHANG) == pid_)
    exit_ = WIFSIGNALED(status) ? Exit{0, WTERMSIG(status)} : Exit{WEXITSTATUS(status), 0};
  return exit_;
}

const std::optional<Exit>& Process::wait(std::chrono::milliseconds deadline) {
  if (!poll() && pidfd_ >= 0) {
    const auto end = std::chrono::steady_clock::now() + deadline;
    pollfd item{pidfd_, POLLIN, 0};
    int left = static_cast<int>(deadline.count());
    while (::poll(&item, 1, left) < 0 && errno == EINTR) // a signal does not shorten the wait
      left = std::max(0, static_cast<int>(std::chrono::duration_cast<std::chrono::milliseconds>(
                                              end - std::chrono::steady_clock::now())
                                              .count()));
    (void)poll();
  }
  return exit_;
}

void Process::kill_session() {
  for (const pid_t pid : family(pid_))
    if (pid > 1 && pid != getpid() && !(pid == pid_ && exit_)) kill(pid, SIGKILL);
  (void)wait(std::chrono::seconds(2)); // a killed process ends at once, unless it hangs in the kernel
}

std::optional<Watch> Watch::on(pid_t pid) {
  const int pidfd = static_cast<int>(syscall(SYS_pidfd_open, pid, 0));
  if (pidfd < 0) return std::nullopt;
  return Watch(pid, pidfd);
}

Watch::~Watch() {
  if (pidfd_ >= 0) close(pidfd_);
}

bool Watch::ended() const {
  pollfd item{pidfd_, POLLIN, 0};
  return ::poll(&item, 1, 0) == 1;
}

Result<fs::path> find_program(const std::string& name) {
  const auto runnable = [](const fs::path& p) {
    return fs::is_regular_file(p) && access(p.c_str(), X_OK) == 0;
  };
  if (name.find('/') != std::string::npos) {
    if (!runnable(name)) return config_error("{} is not a program that can be run", name);
    return fs::absolute(name);
  }
  std::error_code ignored;
  const fs::path own = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  if (runnable(own / name)) return own / name;
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (!folder.empty() && runnable(fs::path(folder) / name)) return fs::path(folder) / name;
  return config_error("there is no program \"{}\" beside the coupler ({}) or in PATH", name, own.string());
}

double peak_memory_mb(pid_t pid) {
  std::ifstream status(fmt::format("/proc/{}/status", pid));
  for (std::string line; std::getline(status, line);)
    if (line.rfind("VmHWM:", 0) == 0) return std::atof(line.c_str() + 6) / 1024; // in kB
  return 0;
}

std::vector<std::string> last_lines(const fs::path& file, std::size_t count) {
  std::ifstream stream(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) {
    lines.push_back(line);
    if (lines.size() > count) lines.erase(lines.begin());
  }
  return lines;
}

} // namespace drogue::launcher
