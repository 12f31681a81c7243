// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace tandem::test {

/// The ports on which a UDP socket of this network namespace listens, each with the number of
/// datagrams that the kernel discarded because the socket's buffer was full.
inline std::map<std::uint16_t, long> udp_losses() {
  std::map<std::uint16_t, long> losses;
  std::ifstream table{"/proc/net/udp"};
  std::string line;
  std::getline(table, line);  // the titles
  while (std::getline(table, line)) {
    std::istringstream in{line};
    const std::vector<std::string> fields{std::istream_iterator<std::string>{in}, {}};
    const std::string& local = fields.at(1);  // "0100007F:1CE8"
    const auto port =
        static_cast<std::uint16_t>(std::stoi(local.substr(local.find(':') + 1), {}, 16));
    losses[port] += std::stol(fields.back());
  }
  return losses;
}

}  // namespace tandem::test
