// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

namespace tandem::test {

/// A DDS domain on loopback that no other test process uses during this object's lifetime. Child
/// processes inherit it.
class PrivateDomain {
 public:
  /// `further`: how many domains above it are kept free, too. More than 120 participants use ports
  /// of the next domain.
  explicit PrivateDomain(int further = 0) {
    for (int tried = 0; tried < kDomains; ++tried) {
      const int domain = 1 + (static_cast<int>(getpid()) + tried) % kDomains;
      if (domain + further > kDomains || !lock(domain, domain + further)) continue;
      setenv("ROS_DOMAIN_ID", std::to_string(domain).c_str(), 1);
      setenv("ROS_LOCALHOST_ONLY", "1", 1);
      return;
    }
    throw std::runtime_error("every test domain is in use");
  }
  ~PrivateDomain() { unlock(); }
  PrivateDomain(const PrivateDomain&) = delete;
  PrivateDomain& operator=(const PrivateDomain&) = delete;

 private:
  static constexpr int kDomains = 100;

  bool lock(int first, int last) {
    for (int domain = first; domain <= last; ++domain) {
      const std::string path = "/tmp/tandem_test_domain_" + std::to_string(domain);
      const int file = open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666);
      if (file >= 0) files_.push_back(file);
      if (file >= 0 && flock(file, LOCK_EX | LOCK_NB) == 0) continue;
      unlock();
      return false;
    }
    return true;
  }

  void unlock() {
    for (const int file : files_) close(file);
    files_.clear();
  }

  std::vector<int> files_;
};

/// Including this header is enough to use a private domain.
inline const PrivateDomain private_domain;

}  // namespace tandem::test
