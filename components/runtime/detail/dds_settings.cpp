// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/dds_settings.hpp"

#include <netdb.h>

#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "tandem/runtime/detail/dds.hpp"
#include "tandem/runtime/environment.hpp"
#if TANDEM_FASTDDS_3
#include <fastdds/LibrarySettings.hpp>
#else
#include <fastrtps/xmlparser/XMLProfileManager.h>
#endif

namespace tandem::runtime {
namespace {

constexpr const char* kEnvironmentFileVariable = "FASTDDS_ENVIRONMENT_FILE";

[[noreturn]] void refuse(const char* variable, const std::string& value, const std::string& why) {
  throw std::runtime_error(
      std::string{variable} + " = '" + value + "': " + why +
      ". Refusing to start, because Fast DDS would continue with its defaults");
}

bool is_port(const std::string& text) {
  int port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc{} && end == text.data() + text.size() && port > 0 && port < 65536;
}

bool resolves(const std::string& host) {
  addrinfo* raw = nullptr;
  const int error = getaddrinfo(host.c_str(), nullptr, nullptr, &raw);
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> found{raw, freeaddrinfo};
  return error == 0;
}

void check_server(const std::string& servers, const std::string& locator) {
  // Optional prefix, host with or without brackets, optional port.
  static const std::regex form{
      R"((?:(?:UDPv4|UDPv6|TCPv4|TCPv6):)?(?:\[([^\]]+)\]|([^:\[\]]+))(?::([^:]*))?)"};
  std::smatch parts;
  if (!std::regex_match(locator, parts, form))
    refuse(kServersVariable, servers,
           "'" + locator + "' is not a locator; write HOST:PORT, separated by ';'");
  if (parts[3].matched && !is_port(parts[3]))
    refuse(kServersVariable, servers, "'" + parts[3].str() + "' is not a port from 1 to 65535");
  const std::string host = parts[1].matched ? parts[1] : parts[2];
  if (!resolves(host))
    refuse(kServersVariable, servers,
           "'" + host + "' is neither an address nor a host name that can be resolved");
}

void check_profiles(const char* name, const std::string& file) {
  if (!std::filesystem::is_regular_file(file))
    refuse(name, file, "no such file; correct the path or unset the variable");
  auto* factory = fdds::DomainParticipantFactory::get_instance();
  if (!ok(factory->load_XML_profiles_file(file)))
    refuse(name, file,
           "not a valid file of Fast DDS profiles; the previous log line names the error");
}

// Fast DDS 3, and so ROS 2 from Kilted on, renamed the variable. Either name works with either
// version; where both are set, the one of this Fast DDS counts.
void check_profiles() {
  const bool other = variable(kProfilesVariable).empty();
  const char* name = other ? kOtherProfilesVariable : kProfilesVariable;
  const std::string file = variable(name);
  if (file.empty()) return;
  if (other) setenv(kProfilesVariable, file.c_str(), 1);
  check_profiles(name, file);
}

}  // namespace

void check_discovery_servers(const std::string& servers) {
  bool any = false;
  std::istringstream stream{servers};
  for (std::string locator; std::getline(stream, locator, ';');) {
    if (locator.empty()) continue;
    check_server(servers, locator);
    any = true;
  }
  if (!any) refuse(kServersVariable, servers, "names no server; unset it to use multicast");
}

void check_dds_settings() {
  if (const auto servers = variable(kServersVariable); !servers.empty())
    check_discovery_servers(servers);
  if (const auto file = variable(kEnvironmentFileVariable);
      !file.empty() && !std::filesystem::is_regular_file(file))
    refuse(kEnvironmentFileVariable, file, "no such file; correct the path or unset the variable");
  check_profiles();
}

void announce_by_network() {
#if TANDEM_FASTDDS_3
  using namespace eprosima::fastdds;
  auto* factory = fdds::DomainParticipantFactory::get_instance();
  LibrarySettings settings;
  factory->get_library_settings(settings);
  if (settings.intraprocess_delivery != INTRAPROCESS_FULL) return;
  settings.intraprocess_delivery = INTRAPROCESS_USER_DATA_ONLY;
  (void)factory->set_library_settings(settings);  // refused if a program's own participant exists
#else
  using eprosima::fastrtps::xmlparser::XMLProfileManager;
  auto settings = XMLProfileManager::library_settings();
  if (settings.intraprocess_delivery != eprosima::fastrtps::INTRAPROCESS_FULL) return;
  settings.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_USER_DATA_ONLY;
  XMLProfileManager::library_settings(settings);
#endif
}

// Without a server, a super client would find nobody. Fast DDS 3 reads the variable itself.
void set_super_client([[maybe_unused]] fdds::DomainParticipantQos& qos) {
#if !TANDEM_FASTDDS_3
  const char* wanted = std::getenv("ROS_SUPER_CLIENT");
  if (wanted == nullptr) return;
  const std::string_view value{wanted};
  if (value != "TRUE" && value != "true" && value != "True" && value != "1") return;
  auto& config = qos.wire_protocol().builtin.discovery_config;
  if (!rtps::load_environment_server_info(config.m_DiscoveryServers)) return;
  if (config.m_DiscoveryServers.empty()) return;
  config.discoveryProtocol = rtps::DiscoveryProtocol_t::SUPER_CLIENT;
#endif
}

}  // namespace tandem::runtime
