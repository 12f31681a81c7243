// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

namespace tandem::test {

/// Two linked network namespaces that stand for two computers. The constructing thread moves into
/// the first. Needs root, iproute2 and nftables; throws std::runtime_error if the kernel does not
/// allow it.
class TwoHosts {
 public:
  TwoHosts() {
    run("ip netns add " + first_);
    run("ip netns add " + second_);
    run("ip link add wire netns " + first_ + " type veth peer name wire netns " + second_);
    configure(first_, "10.99.0.1/24");
    configure(second_, "10.99.0.2/24");
    const int file = open(("/run/netns/" + first_).c_str(), O_RDONLY | O_CLOEXEC);
    const bool moved = file >= 0 && setns(file, CLONE_NEWNET) == 0;
    close(file);
    if (!moved) throw std::runtime_error("cannot enter a network namespace");
  }
  ~TwoHosts() {
    for (const auto& name : {first_, second_})
      (void)!std::system(("ip netns del " + name + " 2>/dev/null").c_str());
  }
  TwoHosts(const TwoHosts&) = delete;
  TwoHosts& operator=(const TwoHosts&) = delete;

  /// Arguments of `ip` that run a program in the second namespace.
  [[nodiscard]] std::vector<std::string> on_second(const std::vector<std::string>& program) const {
    std::vector<std::string> arguments{"netns", "exec", second_};
    arguments.insert(arguments.end(), program.begin(), program.end());
    return arguments;
  }

  /// Drops this percentage of packets at random in each direction.
  void lose(int percent) const {
    const std::string chance =
        percent < 100 ? "numgen random mod 100 '<' " + std::to_string(percent) : "";
    for (const auto& name : {first_, second_}) {
      const std::string nft = "ip netns exec " + name + " nft ";
      run(nft + "flush chain inet wire in");
      if (percent > 0) run(nft + "add rule inet wire in iifname wire " + chance + " drop");
    }
  }

 private:
  static void run(const std::string& command) {
    if (std::system((command + " 2>&1").c_str()) != 0)
      throw std::runtime_error("failed: " + command);
  }
  static void configure(const std::string& name, const std::string& address) {
    const std::string there = "ip netns exec " + name + " ";
    run(there + "ip link set lo up");
    run(there + "ip address add " + address + " dev wire");
    run(there + "ip link set wire up");
    run(there + "ip route add default dev wire");
    run(there +
        "nft 'add table inet wire; add chain inet wire in { type filter hook input priority 0; }'");
  }

  std::string first_ = "tandem_" + std::to_string(getpid()) + "_1",
              second_ = "tandem_" + std::to_string(getpid()) + "_2";
};

}  // namespace tandem::test
