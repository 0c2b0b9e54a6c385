// SPDX-License-Identifier: GPL-3.0-or-later
// A bad network between two network namespaces, made of a tunnel device in each: every packet is delayed, and
// some are lost. Prints "ready" when both ends are up. Needs root, and a kernel with /dev/net/tun.
//
// usage: lossy_link NAMESPACE_A ADDRESS_A NAMESPACE_B ADDRESS_B DELAY_IN_MS LOSS_IN_PERCENT
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <random>
#include <string>
#include <vector>

#include <fcntl.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace {

using Clock = std::chrono::steady_clock;

struct Packet {
  Clock::time_point due;
  std::vector<char> bytes;
};

/// A device inside a namespace; this process stays there. Below 0: it cannot be made.
int open_end(const std::string& name_space, const std::string& address, const std::string& other) {
  const int ns = open(("/run/netns/" + name_space).c_str(), O_RDONLY | O_CLOEXEC);
  if (ns < 0 || setns(ns, CLONE_NEWNET) != 0) return -1;
  const int device = open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC);
  ifreq request{};
  request.ifr_flags = IFF_TUN | IFF_NO_PI;
  std::strncpy(request.ifr_name, "link0", IFNAMSIZ - 1);
  if (device < 0 || ioctl(device, TUNSETIFF, &request) != 0) return -1;
  const std::string up = "ip addr add " + address + " peer " + other +
                         " dev link0 && ip link set link0 up && "
                         "ip link set lo up";
  return std::system(up.c_str()) == 0 ? device : -1;
}

} // namespace

int main(int argc, char** argv) {
  if (argc != 7) return 2;
  const std::array<int, 2> ends{open_end(argv[1], argv[2], argv[4]), open_end(argv[3], argv[4], argv[2])};
  if (ends[0] < 0 || ends[1] < 0) {
    std::perror("lossy_link");
    return 1;
  }
  const auto delay = std::chrono::milliseconds(std::atoi(argv[5]));
  std::mt19937 random(1);
  std::bernoulli_distribution is_lost(std::atof(argv[6]) / 100);
  std::array<std::deque<Packet>, 2> under_way; // to each end
  std::puts("ready");
  std::fflush(stdout);
  long packets = 0, lost = 0;
  while (true) {
    int wait = 1000;
    for (std::size_t to = 0; to < 2; ++to) {
      auto& queue = under_way[to];
      for (; !queue.empty() && queue.front().due <= Clock::now(); queue.pop_front())
        if (write(ends[to], queue.front().bytes.data(), queue.front().bytes.size()) < 0) ++lost;
      if (!queue.empty())
        wait = std::min(wait, 1 + static_cast<int>(std::chrono::duration_cast<std::chrono::milliseconds>(
                                                       queue.front().due - Clock::now())
                                                       .count()));
    }
    std::array<pollfd, 2> items{{{ends[0], POLLIN, 0}, {ends[1], POLLIN, 0}}};
    if (poll(items.data(), items.size(), std::max(wait, 0)) < 0) return 1;
    for (std::size_t from = 0; from < 2; ++from) {
      std::array<char, 65536> buffer;
      for (ssize_t n = 0; (n = read(ends[from], buffer.data(), buffer.size())) > 0;) {
        if (++packets % 1000 == 0) {
          std::printf("%ld packets, %ld lost\n", packets, lost);
          std::fflush(stdout);
        }
        if (is_lost(random))
          ++lost;
        else
          under_way[1 - from].push_back({Clock::now() + delay, {buffer.data(), buffer.data() + n}});
      }
    }
  }
}
