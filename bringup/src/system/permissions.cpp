// SPDX-License-Identifier: Apache-2.0
#include "bringup/system/permissions.hpp"

#include <fnmatch.h>
#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "tandem/runtime/component.hpp"
#include "tandem/runtime/every_node.hpp"
#include "tandem/runtime/names.hpp"

namespace tandem {
namespace {

constexpr const char* kGraph = "ros_discovery_info";
constexpr const char* kHead =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
    "<dds xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\"\n"
    "    xsi:noNamespaceSchemaLocation=\"http://www.omg.org/spec/DDS-SECURITY/20170901/"
    "omg_shared_ca_{}.xsd\">\n";

// "/a" for "a", "*" and "/*".
std::string absolute(const std::string& name) { return name.starts_with('/') ? name : '/' + name; }

std::string resolved(const rt::NodeOptions& options, const std::string& name) {
  if (name == "*") return name;
  return rt::resolve_name(name, rt::make_node_name(options.ns, options.name), options.remappings);
}

// The services and topics of an action, under its full name.
void allow_action(Permissions& permissions, const std::string& action, bool serves) {
  const rt::ActionParts parts = rt::parts_of(action);
  for (const auto& service : {parts.send_goal, parts.cancel_goal, parts.get_result})
    (serves ? allow_serve : allow_call)(permissions, service);
  for (const auto& topic : {parts.feedback, parts.status})
    (serves ? allow_publish : allow_subscribe)(permissions, topic);
}

void add(Permissions& permissions, const rt::NodeOptions& options, const rt::Interface& all) {
  for (const auto& use : all.publishes) allow_publish(permissions, resolved(options, use.name));
  for (const auto& use : all.subscribes) allow_subscribe(permissions, resolved(options, use.name));
  for (const auto& use : all.serves) allow_serve(permissions, resolved(options, use.name));
  for (const auto& use : all.calls) allow_call(permissions, resolved(options, use.name));
  for (const auto& use : all.serves_actions)
    allow_action(permissions, resolved(options, use.name), true);
  for (const auto& use : all.calls_actions)
    allow_action(permissions, resolved(options, use.name), false);
}

// "2026-11-26T20:00:00", in UTC.
std::string iso_time(std::time_t time) { return fmt::format("{:%FT%T}", fmt::gmtime(time)); }

bool covers(const std::string& pattern, const std::string& topic) {
  return fnmatch(pattern.c_str(), topic.c_str(), FNM_NOESCAPE) == 0;
}

// Whether a pattern among the topics matches the topic, or matches all that it matches. Of two
// equal patterns, such as a* and a**, the first is not covered.
bool is_covered(const std::string& topic, const std::set<std::string>& topics) {
  return std::any_of(topics.begin(), topics.end(), [&](const std::string& pattern) {
    return pattern != topic && covers(pattern, topic) &&
           (pattern < topic || !covers(topic, pattern));
  });
}

// The element "publish" or "subscribe" with its topics; empty if there are none. Short, because the
// document is sent in one datagram.
std::string criteria(const char* kind, const std::set<std::string>& topics) {
  if (topics.empty()) return {};
  std::string text = fmt::format("<{}><topics>\n", kind);
  for (const auto& topic : topics)
    if (!is_covered(topic, topics)) text += fmt::format("<topic>{}</topic>\n", topic);
  return text + fmt::format("</topics></{}>\n", kind);
}

std::string element(const char* name, const char* value) {
  return fmt::format("<{0}>{1}</{0}>\n", name, value);
}

}  // namespace

void Permissions::add(const Permissions& others) {
  publish.insert(others.publish.begin(), others.publish.end());
  subscribe.insert(others.subscribe.begin(), others.subscribe.end());
}

void allow_publish(Permissions& permissions, const std::string& topic) {
  permissions.publish.insert("rt" + absolute(topic));
}

void allow_subscribe(Permissions& permissions, const std::string& topic) {
  permissions.subscribe.insert("rt" + absolute(topic));
}

void allow_serve(Permissions& permissions, const std::string& service) {
  permissions.subscribe.insert("rq" + absolute(service) + "Request");
  permissions.publish.insert("rr" + absolute(service) + "Reply");
}

void allow_call(Permissions& permissions, const std::string& service) {
  permissions.publish.insert("rq" + absolute(service) + "Request");
  permissions.subscribe.insert("rr" + absolute(service) + "Reply");
}

Permissions all_permissions() {
  Permissions all{{kGraph}, {kGraph}};
  allow_publish(all, "*");
  allow_subscribe(all, "*");
  allow_serve(all, "*");
  allow_call(all, "*");
  return all;
}

Permissions permissions_of_any(const std::vector<rt::NodeOptions>& nodes) {
  Permissions permissions{{kGraph}, {kGraph}};
  for (const auto& node : nodes) {
    add(permissions, node, rt::every_node::interface());
    allow_serve(permissions, rt::make_node_name(node.ns, node.name).full() + "/*");
  }
  return permissions;
}

Permissions permissions_of(const SystemNode& node) {
  Permissions permissions = permissions_of_any({node.options});
  add(permissions, node.options, rt::description_of(node.component).interface);
  return permissions;
}

std::string permissions_document(const std::string& enclave, const Permissions& permissions,
                                 const Validity& validity, int domain) {
  return fmt::format(fmt::runtime(kHead), "permissions") +
         fmt::format(
             "  <permissions>\n"
             "    <grant name=\"{0}\">\n"
             "      <subject_name>CN={0}</subject_name>\n"
             "      <validity>\n"
             "        <not_before>{1}</not_before>\n"
             "        <not_after>{2}</not_after>\n"
             "      </validity>\n"
             "      <allow_rule>\n"
             "        <domains><id>{3}</id></domains>\n",
             enclave, iso_time(validity.from), iso_time(validity.until), domain) +
         criteria("publish", permissions.publish) + criteria("subscribe", permissions.subscribe) +
         "      </allow_rule>\n"
         "      <default>DENY</default>\n"
         "    </grant>\n"
         "  </permissions>\n"
         "</dds>\n";
}

std::string governance_document(int domain) {
  const std::string in = "      ", deep = "          ";
  return fmt::format(fmt::runtime(kHead), "governance") +
         "  <domain_access_rules>\n"
         "    <domain_rule>\n" +
         in + fmt::format("<domains><id>{}</id></domains>\n", domain) + in +
         element("allow_unauthenticated_participants", "false") + in +
         element("enable_join_access_control", "true") + in +
         element("discovery_protection_kind", "ENCRYPT") + in +
         element("liveliness_protection_kind", "ENCRYPT") + in +
         element("rtps_protection_kind", "SIGN") + in +
         "<topic_access_rules>\n"
         "        <topic_rule>\n" +
         deep + element("topic_expression", "*") + deep +
         element("enable_discovery_protection", "true") + deep +
         element("enable_liveliness_protection", "true") + deep +
         element("enable_read_access_control", "true") + deep +
         element("enable_write_access_control", "true") + deep +
         element("metadata_protection_kind", "ENCRYPT") + deep +
         element("data_protection_kind", "ENCRYPT") + "        </topic_rule>\n" + in +
         "</topic_access_rules>\n"
         "    </domain_rule>\n"
         "  </domain_access_rules>\n"
         "</dds>\n";
}

}  // namespace tandem
