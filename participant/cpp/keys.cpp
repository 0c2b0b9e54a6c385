// SPDX-License-Identifier: GPL-3.0-or-later
#include "participant/cpp/keys.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace drogue::keys {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t key_length = 40;
constexpr const char* alphabet =
    "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ.-:+=^!/*?&<>()[]{}@%$#";

Result<void> write_new(const fs::path& file, const std::string& text, mode_t mode) {
  const int out = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  if (out < 0 && errno == EEXIST)
    return config_error("{} is there already: a key is never written over", file.string());
  if (out < 0) return config_error("cannot write {}: {}", file.string(), std::strerror(errno));
  const bool written = ::write(out, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const int reason = errno;
  close(out);
  return written ? Result<void>() : config_error("cannot write {}: {}", file.string(), std::strerror(reason));
}

/// The key after a word at the start of a line; empty when there is none.
std::string key_of(const fs::path& file, const std::string& word) {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);)
    if (line.rfind(word + " ", 0) == 0 && is_key(line.substr(word.size() + 1)))
      return line.substr(word.size() + 1);
  return {};
}

Error no_key(const fs::path& file, const char* what) {
  return config_error("{} holds no {} key: coupler keygen makes such files", file.string(), what);
}

} // namespace

Result<KeyPair> make() {
  std::array<char, key_length + 1> public_half{}, secret_half{};
  if (zmq_curve_keypair(public_half.data(), secret_half.data()) != 0)
    return internal_error("this ZeroMQ library makes no keys: {}", zmq_strerror(zmq_errno()));
  return KeyPair{public_half.data(), secret_half.data()};
}

Result<void> write(const fs::path& folder, const std::string& name, const KeyPair& pair) {
  DROGUE_TRY(
      write_new(folder / (name + ".key"),
                fmt::format("# Drogue key pair \"{}\": whoever reads the secret half can pass for its owner\n"
                            "public {}\nsecret {}\n",
                            name, pair.public_half, pair.secret_half),
                0600));
  return write_new(
      folder / (name + ".pub"),
      fmt::format("# Drogue public key \"{}\": for everybody\npublic {}\n", name, pair.public_half), 0644);
}

Result<KeyPair> read_pair(const fs::path& file) {
  struct stat status {};
  if (stat(file.c_str(), &status) != 0)
    return config_error("cannot read the key {}: {}", file.string(), std::strerror(errno));
  if ((status.st_mode & (S_IRWXG | S_IRWXO)) != 0)
    return config_error("others may read the key {}: chmod 600 it", file.string());
  KeyPair pair{key_of(file, "public"), key_of(file, "secret")};
  if (pair.secret_half.empty()) return no_key(file, "secret");
  std::array<char, key_length + 1> own{};
  if (zmq_curve_public(own.data(), pair.secret_half.c_str()) != 0 || pair.public_half != own.data())
    return config_error("{}: the two halves do not belong together", file.string());
  return pair;
}

Result<std::string> read_public(const fs::path& file) {
  std::string key = key_of(file, "public");
  return key.empty() ? Result<std::string>(no_key(file, "public")) : key;
}

bool is_key(const std::string& text) {
  return text.size() == key_length && text.find_first_not_of(alphabet) == std::string::npos;
}

bool stays_on_this_machine(const std::string& endpoint) {
  if (endpoint.rfind("ipc://", 0) == 0 || endpoint.rfind("inproc://", 0) == 0) return true;
  const std::string tcp = "tcp://";
  if (endpoint.rfind(tcp, 0) != 0) return false;
  const std::string host = endpoint.substr(tcp.size(), endpoint.rfind(':') - tcp.size());
  return host == "localhost" || host == "[::1]" ||
         (host.rfind("127.", 0) == 0 && host.find_first_not_of("0123456789.") == std::string::npos);
}

void use(zmq::socket_t& socket, const KeyPair& own, const std::string& coupler_key) {
  socket.set(zmq::sockopt::curve_serverkey, coupler_key);
  socket.set(zmq::sockopt::curve_publickey, own.public_half);
  socket.set(zmq::sockopt::curve_secretkey, own.secret_half);
}

} // namespace drogue::keys
