// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/participant.hpp"

#include <arpa/inet.h>
#include <netdb.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <stdexcept>

#include "tandem/runtime/detail/clock_source.hpp"
#include "tandem/runtime/detail/codec.hpp"
#include "tandem/runtime/detail/dds_log.hpp"
#include "tandem/runtime/detail/dds_settings.hpp"
#include "tandem/runtime/detail/graph.hpp"
#include "tandem/runtime/detail/guarded_transport.hpp"
#include "tandem/runtime/detail/participant_ports.hpp"
#include "tandem/runtime/detail/priority_of_dds.hpp"
#include "tandem/runtime/detail/security_fault.hpp"
#include "tandem/runtime/detail/thread_limit.hpp"
#include "tandem/runtime/detail/wire_guard.hpp"
#include "tandem/runtime/log.hpp"
#include "tandem/runtime/names.hpp"

namespace tandem::runtime {
namespace {

constexpr const char* kLoopback = "127.0.0.1";
constexpr const char* kMulticast = "239.255.0.1";  // of discovery: OMG RTPS 2.5, 9.6.2.4.1
constexpr int kParticipantThreads = 8;             // needed by Fast DDS 2.9, with some margin
constexpr uint32_t kSocketBuffer = 4U << 20;       // [bytes]; the kernel lowers it to its own limit
constexpr int kSpareIds = 16;  // asked beyond the own id, because others may start meanwhile

// Resolves a host name to its first IPv4 address; an address resolves to itself.
std::string resolved(const std::string& host) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* raw = nullptr;
  const int error = getaddrinfo(host.c_str(), nullptr, &hints, &raw);
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> found{raw, freeaddrinfo};
  if (error != 0)
    throw std::runtime_error("ROS_STATIC_PEERS: '" + host +
                             "' is neither an IPv4 address nor a known host name (" +
                             gai_strerror(error) + ")");
  char text[INET_ADDRSTRLEN];
  sockaddr_in address{};
  std::memcpy(&address, found->ai_addr, sizeof address);
  return inet_ntop(AF_INET, &address.sin_addr, text, sizeof text);
}

rtps::Locator_t peer(const std::string& host) {
  rtps::Locator_t locator;
  locator.kind = LOCATOR_KIND_UDPv4;
  if (!IpLocator::setIPv4(locator, resolved(host)))
    throw std::runtime_error("ROS_STATIC_PEERS: '" + host + "' is not an IPv4 address");
  locator.port = 0;  // 0 means the ports of the first kIdsAsked ids
  return locator;
}

// The discovery port of participant `id` of this host.
rtps::Locator_t local_peer(int domain, int id) {
  auto locator = peer(kLoopback);
  locator.port = static_cast<uint32_t>(discovery_port(domain, id));
  return locator;
}

rtps::Locator_t on_all_interfaces(int port) {
  rtps::Locator_t any;
  any.kind = LOCATOR_KIND_UDPv4;
  any.port = static_cast<uint32_t>(port);
  return any;
}

// Listens on the ports of participant `id`, or on the next ones that are free. By default, Fast DDS
// never gives a process an id twice: the 121st participant made by one process would take the next
// domain's multicast port, and participants of that domain would not find each other.
void set_ports(fdds::DomainParticipantQos& qos, const Environment& environment, int id) {
  const int port = discovery_port(environment.domain, id);
  auto& builtin = qos.wire_protocol().builtin;
  builtin.metatrafficUnicastLocatorList.push_back(on_all_interfaces(port));
  qos.wire_protocol().default_unicast_locator_list.push_back(on_all_interfaces(port + 1));
  if (environment.range != DiscoveryRange::kLocalhost)
    builtin.metatrafficMulticastLocatorList.push_back(peer(kMulticast));
}

// Disables multicast: a participant that is given a unicast port only does without.
void use_unicast_discovery(fdds::DomainParticipantQos& qos) {
  auto& unicast = qos.wire_protocol().builtin.metatrafficUnicastLocatorList;
  if (unicast.empty()) unicast.push_back(on_all_interfaces(0));
}

// `asked`: with range LOCALHOST, how many ids of this host are asked.
void set_peers(fdds::DomainParticipantQos& qos, const Environment& environment, int asked) {
  auto& peers = qos.wire_protocol().builtin.initialPeersList;
  for (const auto& address : environment.static_peers) peers.push_back(peer(address));
  switch (environment.range) {
    case DiscoveryRange::kSubnet:
      if (!environment.static_peers.empty()) peers.push_back(peer(kMulticast));
      break;
    case DiscoveryRange::kLocalhost:
      use_unicast_discovery(qos);
      peers.push_back(peer(kLoopback));
      for (int id = kIdsAsked; id < asked; ++id)
        peers.push_back(local_peer(environment.domain, id));
      break;
    case DiscoveryRange::kOff:
      qos.wire_protocol().builtin.discovery_config.ignoreParticipantFlags =
          static_cast<rtps::ParticipantFilteringFlags>(
              rtps::ParticipantFilteringFlags::FILTER_DIFFERENT_HOST |
              rtps::ParticipantFilteringFlags::FILTER_DIFFERENT_PROCESS);
      break;
  }
}

std::shared_ptr<TransportDescriptor> udp_transport(const Environment& environment) {
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->maxInitialPeersRange = kIdsAsked;
  udp->sendBufferSize = kSocketBuffer;
  udp->receiveBufferSize = kSocketBuffer;
  // Not for range LOCALHOST: ROS 2 announces all host addresses there, and a socket bound to the
  // loopback could not reach them.
  if (environment.loopback_only) udp->interfaceWhiteList.push_back(kLoopback);
  return udp;
}

// Fast DDS's default transports are UDP and shared memory, both unguarded.
void replace_builtin_transports(fdds::DomainParticipantQos& qos, const Environment& environment) {
  if (!qos.transport().use_builtin_transports) return;
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp_transport(environment));
}

void guard_transports(fdds::DomainParticipantQos& qos, const Environment& environment,
                      const std::function<void(uint32_t)>& listening) {
  for (auto& transport : qos.transport().user_transports) {
    if (auto behind_guard = guarded(transport, listening))
      transport = std::move(behind_guard);
    else if (!environment.unguarded_transports)
      throw std::runtime_error(
          std::string{kProfilesVariable} +
          " names a transport other than UDP: packets on it are not checked, and a malformed one "
          "can crash this process. Keep only UDP transports in the file, or set "
          "TANDEM_UNGUARDED_TRANSPORTS=1 to run anyway");
  }
}

void set_transport(fdds::DomainParticipantQos& qos, const Environment& environment,
                   const std::function<void(uint32_t)>& listening) {
  const bool from_profile =
      std::getenv(kProfilesVariable) != nullptr && !qos.transport().user_transports.empty();
  if (!from_profile) {
    qos.transport().user_transports.clear();
    qos.transport().use_builtin_transports = true;
  }
  if (!from_profile || !environment.unguarded_transports)
    replace_builtin_transports(qos, environment);
  guard_transports(qos, environment, listening);
}

// Replaces the security settings of an XML profile.
void secure(fdds::DomainParticipantQos& qos, const Security& security) {
  if (!security.on()) return;
  auto& properties = qos.properties().properties();
  std::erase_if(properties, [](const auto& known) { return known.name().starts_with("dds.sec."); });
  for (const auto& [name, value] : security.properties) properties.emplace_back(name, value);
}

fdds::DomainParticipantQos participant_qos(const Environment& environment,
                                           const Security& security) {
  fdds::DomainParticipantQos qos;
  auto* factory = fdds::DomainParticipantFactory::get_instance();
  factory->load_profiles();
  announce_by_network();
  factory->get_default_participant_qos(qos);
  qos.name(enclave());
  const std::string user_data = "enclave=" + enclave() + ";";
  qos.user_data().data_vec({user_data.begin(), user_data.end()});
  qos.wire_protocol().builtin.readerHistoryMemoryPolicy =
      rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos.wire_protocol().builtin.writerHistoryMemoryPolicy =
      rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  // Fast DDS takes the first id whose ports are free, but by default tries 100 only. Without ports
  // a participant exists and nobody finds it.
  qos.wire_protocol().builtin.mutation_tries =
      static_cast<uint32_t>(max_participant_id(environment.domain));
  set_super_client(qos);
  secure(qos, security);
  return qos;
}

template <class Entity>
Entity* created(Entity* entity, const std::string& what) {
  if (entity == nullptr) throw std::runtime_error("DDS refused to create " + what);
  return entity;
}

constexpr int kNoId = -1;  // range OFF, a profile that sets other ports, or no port is free

// The ports on which a participant listens.
struct HeldPorts {
  std::atomic<int> id = kNoId;
  std::atomic<bool> by_multicast = false;
};

// A participant, and the id that it got on this host, by its ports.
struct NewParticipant {
  fdds::DomainParticipant* dds;
  int id;
};

// Whether the ports are ours to choose; a discovery server's clients are found by other means.
bool chooses_ports(const Environment& environment) {
  return variable(kProfilesVariable).empty() && variable(kServersVariable).empty() &&
         environment.range != DiscoveryRange::kOff;
}

// `free_id`: the first id whose port is free. `asked`: see set_peers().
NewParticipant create(const Environment& environment, fdds::DomainParticipantQos qos, int free_id,
                      int asked, fdds::DomainParticipantListener* listener) {
  const auto held = std::make_shared<HeldPorts>();  // the transport lives longer
  set_transport(qos, environment, [held, domain = environment.domain](uint32_t port) {
    const auto id = participant_id(domain, port);
    if (id && held->id == kNoId) held->id = *id;
    if (port == static_cast<uint32_t>(multicast_port(domain))) held->by_multicast = true;
  });
  if (chooses_ports(environment)) set_ports(qos, environment, free_id);
  set_peers(qos, environment, asked);
  auto* dds = made_with_priority_of_dds([&] {
    return fdds::DomainParticipantFactory::get_instance()->create_participant(
        static_cast<uint32_t>(environment.domain), qos, listener, fdds::StatusMask::none());
  });
  if (dds != nullptr && chooses_ports(environment)) warn_if_deaf(environment, held->by_multicast);
  return {dds, held->id};
}

void destroy(fdds::DomainParticipant* dds) {
  dds->set_listener(nullptr);
  fdds::DomainParticipantFactory::get_instance()->delete_participant(dds);
}

// With range LOCALHOST, a participant asks all ids up to its own, so that of any two on this host
// the one with the higher id finds the other. Which id it gets is known once it exists.
NewParticipant create(const Environment& environment, const fdds::DomainParticipantQos& qos,
                      fdds::DomainParticipantListener* listener) {
  const int free_id = first_free_id(environment.domain);
  int asked = std::max(kIdsAsked, free_id + kSpareIds);
  for (;;) {
    const auto created = create(environment, qos, free_id, asked, listener);
    const bool asks_enough = environment.range != DiscoveryRange::kLocalhost || created.id < asked;
    if (created.dds == nullptr || asks_enough) return created;
    asked = created.id + kSpareIds;
    destroy(created.dds);
  }
}

// Explains why DDS refused a participant; its own messages say little about faults of an enclave.
std::string refusal(const Security& security, const DdsErrors& errors) {
  if (!security.on()) return ": " + errors.first();
  const std::string fault = security_fault(security.folder);
  return " secured by " + security.folder + ": " + (fault.empty() ? errors.first() : fault);
}

}  // namespace

SharedTopic::SharedTopic(Participant& first, const std::string& dds_name,
                         const std::string& dds_type)
    : participant_{&first}, name_{dds_name}, dds_{first.acquire_topic(dds_name, dds_type)} {
  if (dds_ != nullptr) return;
  participant_ = &first.second();
  dds_ = participant_->acquire_topic(dds_name, dds_type);
  if (dds_ == nullptr)
    throw std::runtime_error(
        "topic " + ros_name(dds_name) +
        " is in use in this process with two other types, so it cannot have type " +
        ros_type(dds_type) + " too");
}

SharedTopic::~SharedTopic() { participant_->release_topic(name_); }

std::shared_ptr<Participant> Participant::shared() {
  static std::mutex mutex;
  static std::weak_ptr<Participant> current;
  const std::lock_guard lock{mutex};
  if (auto participant = current.lock()) return participant;
  const Environment environment = read_environment();
  const Security security = find_security(environment.security, enclave());
  std::shared_ptr<Participant> participant{new Participant{environment, security, true}};
  current = participant;
  return participant;
}

// Only the first participant has a discovery listener; it discovers the second like any other.
Participant::Participant(const Environment& environment, const Security& security, bool is_first)
    : environment_{environment}, security_{security} {
  redirect_dds_log();
  check_dds_settings();
  require_threads(kParticipantThreads);
  if (is_first && environment.unguarded_transports)
    Logger{"runtime"}.warn(
        "TANDEM_UNGUARDED_TRANSPORTS=1: transports other than UDP may be used; packets on them are "
        "not checked, and a malformed one can crash this process");
  process_guard().expect_protection(security.protects_all);
  const DdsErrors errors;
  const auto participant =
      create(environment, participant_qos(environment, security), is_first ? &discovery_ : nullptr);
  dds_ = participant.dds;
  if (dds_ == nullptr)
    throw std::runtime_error("DDS refused to create a participant in domain " +
                             std::to_string(environment.domain) + refusal(security, errors));
  const bool needs_ports =
      environment.range != DiscoveryRange::kOff && variable(kProfilesVariable).empty();
  if (participant.id == kNoId && needs_ports) {
    destroy(dds_);
    throw std::runtime_error(
        fmt::format("domain {} has no free UDP port left for a further participant on this host: "
                    "stop some processes, or use further domains",
                    environment.domain));
  }
  publisher_ = created(dds_->create_publisher(fdds::PUBLISHER_QOS_DEFAULT), "a publisher");
  subscriber_ = created(dds_->create_subscriber(fdds::SUBSCRIBER_QOS_DEFAULT), "a subscriber");
  graph_ = std::make_unique<Graph>(*this, is_first ? Graph::Nodes::kOwn : Graph::Nodes::kHidden);
}

Participant& Participant::second() {
  const std::lock_guard lock{mutex_};
  if (!second_) second_.reset(new Participant{environment_, security_, false});
  known_second_ = second_.get();
  return *second_;
}

void Participant::publish_ends() {
  graph_->publish_ends();
  if (Participant* second = known_second_) second->graph_->publish_ends();
}

std::shared_ptr<ClockSource> Participant::clock(const Endpoint& endpoint) {
  const std::lock_guard lock{clocks_mutex_};
  std::erase_if(clocks_, [](const auto& source) { return source.expired(); });
  for (const auto& known : clocks_)
    if (auto source = known.lock(); source && source->reads(endpoint)) return source;
  auto source = std::make_shared<ClockSource>(*this, endpoint);
  clocks_.push_back(source);
  return source;
}

bool Participant::is_own(const rtps::GUID_t& guid) {
  const std::lock_guard lock{mutex_};
  return guid.guidPrefix == dds_->guid().guidPrefix ||
         (second_ && guid.guidPrefix == second_->dds_->guid().guidPrefix);
}

// Destroy the second participant only after all endpoints of the first: their removal is reported
// to the second too, and Fast DDS 2.9 calls readers in the same process by pointers that may
// dangle.
Participant::~Participant() {
  graph_.reset();
  dds_->set_listener(nullptr);
  dds_->delete_contained_entities();
  second_.reset();
  fdds::DomainParticipantFactory::get_instance()->delete_participant(dds_);
}

fdds::Topic* Participant::acquire_topic(const std::string& dds_name, const std::string& dds_type) {
  const std::lock_guard lock{mutex_};
  const auto known = topics_.find(dds_name);
  if (known == topics_.end()) {
    register_type(dds_type);
    auto* topic = created(dds_->create_topic(dds_name, dds_type, fdds::TOPIC_QOS_DEFAULT),
                          "topic " + dds_name + " of type " + dds_type);
    topics_[dds_name] = {topic, dds_type, 1};
    return topic;
  }
  if (known->second.type != dds_type) return nullptr;
  ++known->second.users;
  return known->second.dds;
}

void Participant::release_topic(const std::string& dds_name) {
  const std::lock_guard lock{mutex_};
  const auto known = topics_.find(dds_name);
  if (--known->second.users > 0) return;
  dds_->delete_topic(known->second.dds);
  topics_.erase(known);
}

void Participant::register_type(const std::string& dds_type) {
  if (types_.contains(dds_type)) return;
  fdds::TypeSupport type{new BytesType{dds_type, largest_sample_of(ros_type(dds_type))}};
  if (!ok(type.register_type(dds_)))
    throw std::runtime_error("DDS refused to register type " + dds_type);
  types_.emplace(dds_type, type);
}

}  // namespace tandem::runtime
