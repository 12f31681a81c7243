// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cstdlib>
#include <stdexcept>
#include <string>

namespace tandem::test {

/// A DDS domain on loopback that no other test process uses during this object's lifetime. Child
/// processes inherit it.
class PrivateDomain {
 public:
  PrivateDomain() {
    for (int tried = 0; tried < kDomains; ++tried) {
      const int domain = 1 + (static_cast<int>(getpid()) + tried) % kDomains;
      if (!lock(domain)) continue;
      setenv("ROS_DOMAIN_ID", std::to_string(domain).c_str(), 1);
      setenv("ROS_LOCALHOST_ONLY", "1", 1);
      return;
    }
    throw std::runtime_error("every test domain is in use");
  }
  ~PrivateDomain() { close(file_); }
  PrivateDomain(const PrivateDomain&) = delete;
  PrivateDomain& operator=(const PrivateDomain&) = delete;

 private:
  static constexpr int kDomains = 100;

  bool lock(int domain) {
    const std::string path = "/tmp/tandem_test_domain_" + std::to_string(domain);
    file_ = open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666);
    if (file_ >= 0 && flock(file_, LOCK_EX | LOCK_NB) == 0) return true;
    if (file_ >= 0) close(file_);
    return false;
  }

  int file_ = -1;
};

/// Including this header is enough to use a private domain.
inline const PrivateDomain private_domain;

}  // namespace tandem::test
