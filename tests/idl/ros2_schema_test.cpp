// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <msgs.hpp>
#include <regex>
#include <ros2_schema.hpp>
#include <string>

#include "support/paths.hpp"

namespace tandem::runtime {
namespace {

TEST(Ros2Msg, WritesATypeAsItsMsgFileDoes) {
  EXPECT_EQ(ros2msg("geometry_msgs/msg/Vector3"), "float64 x\nfloat64 y\nfloat64 z\n");
  EXPECT_EQ(ros2msg("std_srvs/srv/Trigger_Response"), "bool success\nstring message\n");
}

TEST(Ros2Msg, PutsTheTypesThatItIsMadeOfBehindIt) {
  const std::string line(80, '=');
  EXPECT_EQ(ros2msg("sensor_msgs/msg/Joy"),
            "std_msgs/Header header\nfloat32[] axes\nint32[] buttons\n" + line +
                "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n" + line +
                "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n");
}

TEST(Ros2Msg, WritesArraysAndBounds) {
  const std::string odometry = ros2msg("nav_msgs/msg/Odometry").value_or("");
  EXPECT_NE(odometry.find("float64[36] covariance"), std::string::npos);
  const std::string descriptor = ros2msg("rcl_interfaces/msg/ParameterDescriptor").value_or("");
  EXPECT_NE(descriptor.find("rcl_interfaces/FloatingPointRange[<=1] floating_point_range"),
            std::string::npos);
  EXPECT_EQ(ros2msg("no_such/msg/Type"), std::nullopt);
}

TEST(Ros2Msg, WritesDefaultValues) {
  EXPECT_EQ(ros2msg("geometry_msgs/msg/Quaternion"),
            "float64 x 0.0\nfloat64 y 0.0\nfloat64 z 0.0\nfloat64 w 1.0\n");
  EXPECT_EQ(geometry_msgs::msg::Quaternion{}.w(), 1.0);
  const std::string request =
      ros2msg("type_description_interfaces/srv/GetTypeDescription_Request").value_or("");
  EXPECT_NE(request.find("bool include_type_sources true\n"), std::string::npos) << request;
}

TEST(Ros2Msg, WritesTheEventsOfAService) {
  const std::string event = ros2msg("std_srvs/srv/Trigger_Event").value_or("");
  EXPECT_EQ(event.substr(0, event.find("====")),
            "service_msgs/ServiceEventInfo info\nstd_srvs/Trigger_Request[<=1] request\n"
            "std_srvs/Trigger_Response[<=1] response\n");
}

TEST(Ros2Msg, WritesConstants) {
  const std::string field = ros2msg("sensor_msgs/msg/PointField").value_or("");
  EXPECT_NE(field.find("uint8 INT8=1\n"), std::string::npos) << field;
  const std::string level = ros2msg("diagnostic_msgs/msg/DiagnosticStatus").value_or("");
  EXPECT_NE(level.find("byte STALE=3\n"), std::string::npos) << level;
}

// Without comments and the name of the package, which a type of its own may omit.
std::string members_in(const std::filesystem::path& msg_file) {
  std::ifstream in{msg_file};
  std::string members;
  for (std::string line; std::getline(in, line);) {
    line = line.substr(0, line.find("  #"));
    if (!line.starts_with("#")) members += line + "\n";
  }
  return members;
}

TEST(Ros2Msg, WritesOurTypesAsTheirRosPackageDoes) {
  const std::regex own{"tandem_msgs/"};
  int files = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator{test::source_path("idl/tandem_msgs/msg")}) {
    const std::string all = ros2msg("tandem_msgs/msg/" + entry.path().stem().string()).value_or("");
    EXPECT_EQ(std::regex_replace(all.substr(0, all.find("=====")), own, ""),
              members_in(entry.path()));
    ++files;
  }
  EXPECT_GE(files, 7);
}

}  // namespace
}  // namespace tandem::runtime
