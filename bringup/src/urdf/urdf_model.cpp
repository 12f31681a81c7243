// SPDX-License-Identifier: Apache-2.0
#include "bringup/urdf/urdf_model.hpp"

#include <fstream>
#include <iterator>
#include <stdexcept>
#include <utility>
#include <vector>

#include <console_bridge/console.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>
#include <urdf_parser/urdf_parser.h>

#include "tandem/config/printable.hpp"

namespace tandem {
namespace {

// While it exists, collects the errors that urdfdom logs. It reports errors in no other way, and
// leaves out a geometry that it cannot read.
class CollectedErrors final : public console_bridge::OutputHandler {
 public:
  CollectedErrors() { console_bridge::useOutputHandler(this); }
  ~CollectedErrors() override { console_bridge::restorePreviousOutputHandler(); }
  CollectedErrors(const CollectedErrors&) = delete;
  CollectedErrors& operator=(const CollectedErrors&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char* /*file*/,
           int /*line*/) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_ERROR) return;
    text_ += (text_.empty() ? "" : "; ") + text;
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

std::string content_of(const std::filesystem::path& file) {
  std::ifstream stream{file, std::ios::binary};
  std::string text{std::istreambuf_iterator<char>{stream}, {}};
  if (!stream || std::filesystem::is_directory(file)) throw std::runtime_error("cannot be read");
  return text;
}

void erase_comments(std::string& xml) {
  for (auto from = xml.find("<!--"); from != std::string::npos; from = xml.find("<!--", from)) {
    const auto end = xml.find("-->", from);
    xml.erase(from, end == std::string::npos ? end : end + 3 - from);
  }
}

// The output of xacro still declares its namespace, and may have macros in its comments.
bool has_macros(std::string xml) {
  erase_comments(xml);
  return xml.find("<xacro:") != std::string::npos || xml.find("${") != std::string::npos;
}

urdf::ModelInterfaceSharedPtr parse(const std::string& xml) {
  if (has_macros(xml))
    throw std::runtime_error(
        "contains macros of xacro; expand them first: xacro FILE > robot.urdf");
  const CollectedErrors errors;
  auto model = urdf::parseURDF(xml);
  if (!model || !errors.text().empty())
    throw std::runtime_error("not a valid URDF: " + errors.text());
  return model;
}

template <class Named>
std::string names_in(const std::map<std::string, Named>& all) {
  std::vector<std::string> names;
  for (const auto& [name, value] : all) names.push_back(name);
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

Eigen::Isometry3d to_isometry(const urdf::Pose& pose) {
  const auto& p = pose.position;
  const auto& q = pose.rotation;
  return Eigen::Translation3d(p.x, p.y, p.z) * Eigen::Quaterniond(q.w, q.x, q.y, q.z);
}

UrdfModel::UrdfModel(std::filesystem::path file) : file_{std::move(file)} {
  try {
    tree_ = parse(content_of(file_));
  } catch (const std::exception& error) {
    fail(error.what());
  }
  place(tree_->getRoot(), Eigen::Isometry3d::Identity(), tree_->getRoot()->name);
  for (const auto& [name, link] : tree_->links_)
    if (!links_.contains(name)) fail("the joints above link '" + name + "' form a loop");
}

void UrdfModel::place(const urdf::LinkConstSharedPtr& link, const Eigen::Isometry3d& X_RL,
                      const std::string& body) {
  if (!links_.emplace(link->name, PlacedLink{link, X_RL, body}).second)
    fail("link '" + link->name + "' is the child of several joints");
  for (const auto& joint : link->child_joints)
    place(tree_->getLink(joint->child_link_name),
          X_RL * to_isometry(joint->parent_to_joint_origin_transform),
          joint->type == urdf::Joint::FIXED ? body : joint->child_link_name);
}

const PlacedLink& UrdfModel::link(const std::string& name) const {
  const auto found = links_.find(name);
  if (found == links_.end()) fail("has no link '" + name + "'; its links: " + names_in(links_));
  return found->second;
}

const urdf::Joint& UrdfModel::joint(const std::string& name) const {
  const auto found = joints().find(name);
  if (found == joints().end())
    fail("has no joint '" + name + "'; its joints: " + names_in(joints()));
  return *found->second;
}

const Eigen::Isometry3d& UrdfModel::pose_of(const urdf::Joint& joint) const {
  return links_.at(joint.child_link_name).X_RL;
}

void UrdfModel::fail(std::string_view what) const {
  throw std::runtime_error(printable(file_.string() + ": " + std::string{what}));
}

}  // namespace tandem
