// SPDX-License-Identifier: Apache-2.0
// Tests which of the maps that arrive is in force.
#include "tandem/io/map_input.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "support/captured_log.hpp"
#include "support/private_domain.hpp"
#include "support/spin_until.hpp"
#include "system/wall_map.hpp"
#include "tandem/io/conversions.hpp"
#include "tandem/io/reason_code.hpp"
#include "tandem/io/topics.hpp"

namespace tandem::test {
namespace {

constexpr double kMapTimeout = 10.0;  // [s]
const Eigen::Vector2d kAtWall{kWall + 0.02, 0.0}, kOrigin{0.0, 0.0};

class MapInputOverDds : public testing::Test {
 protected:
  void listen(const MapInputParams& params = {}) { input_.emplace(node_, params, frames_); }
  [[nodiscard]] std::shared_ptr<const StaticMap> map() { return input_->map(std::nullopt); }
  [[nodiscard]] bool has_wall() { return map() && map()->distance(kAtWall) == 0.0; }
  template <class Done>
  [[nodiscard]] bool wait_until(Done done) {
    return spin_until(done, kMapTimeout, node_, server_);
  }
  // The wall's frame at the origin of `map`.
  void publish_frame(const rt::Publisher<tf2_msgs::msg::TFMessage>& tf) const {
    tf2_msgs::msg::TFMessage msg;
    msg.transforms({to_transform(Pose2{}, header(server_.stamp(), "map"), "odom")});
    tf.publish(msg);
  }

  rt::Node node_{"reader"}, server_{"server"};
  FramesInput frames_{node_, Frames{}, LocalizationParams{}};
  std::optional<MapInput> input_;
  std::optional<rt::Publisher<octomap_msgs::msg::Octomap>> publisher_ =
      server_.create_publisher(topics::octomap_binary);
};

TEST_F(MapInputOverDds, HasNoMapBeforeTheFirstArrives) {
  listen();
  EXPECT_EQ(map(), nullptr);
  EXPECT_EQ(input_->missing(), text_of(Reason::kNoMapYet));
  EXPECT_STREQ(input_->missing_topic(), "octomap_binary");
  publisher_->publish(wall("map"));
  ASSERT_TRUE(wait_until([&] { return has_wall(); }));
  EXPECT_GT(map()->distance(kOrigin), 0.5);
}

TEST_F(MapInputOverDds, ABrokenMapLeavesTheOldOneInForce) {
  const CapturedLog log;
  listen();
  publisher_->publish(wall("map"));
  ASSERT_TRUE(wait_until([&] { return has_wall(); }));
  auto broken = wall("map");
  broken.data(std::vector<std::int8_t>(1000, 0x55));
  publisher_->publish(broken);
  ASSERT_TRUE(wait_until([&] { return log.lines("octomap_binary refused: ") == 1; }));
  EXPECT_TRUE(has_wall());
}

TEST_F(MapInputOverDds, MapsOfTwoPublishersAreRefusedUntilOneIsLeft) {
  const CapturedLog log;
  listen();
  publisher_->publish(wall("map"));
  ASSERT_TRUE(wait_until([&] { return has_wall(); }));
  auto other = std::make_optional(server_.create_publisher(topics::octomap_binary));
  ASSERT_TRUE(wait_until([&] { return other->matched() > 0; }));
  octomap::OcTree empty(0.05);
  empty.updateNode(5.0, 5.0, 0.3, true);
  auto foreign = wall("map");
  foreign.data(encode_octomap(empty));
  other->publish(foreign);
  ASSERT_TRUE(wait_until([&] { return log.lines("2 nodes publish it") > 0; }));
  EXPECT_TRUE(has_wall());
  publisher_.reset();
  ASSERT_TRUE(wait_until([&] { return map() && map()->distance(kAtWall) > 0.5; }))
      << "the map of the publisher that is left";
}

TEST_F(MapInputOverDds, AMapInAnUnknownFrameWaitsForItsTransform) {
  listen();
  publisher_->publish(wall("odom"));
  ASSERT_TRUE(wait_until([&] { return input_->missing() != text_of(Reason::kNoMapYet); }));
  EXPECT_EQ(map(), nullptr);
  EXPECT_NE(input_->missing().find("odom"), std::string::npos) << input_->missing();
  const auto tf = server_.create_publisher(topics::tf);
  EXPECT_TRUE(wait_until([&] {
    publish_frame(tf);
    return has_wall();
  }));
}

TEST_F(MapInputOverDds, ALocalMapThatFallsSilentIsNoMap) {
  listen({.slice = {}, .fixtures = {}, .map_source = "local", .local_timeout = 0.3});
  EXPECT_STREQ(input_->missing_topic(), "octomap_local");
  const auto local = server_.create_publisher(topics::octomap_local);
  ASSERT_TRUE(wait_until([&] {
    local.publish(wall("map"));
    return has_wall();
  }));
  ASSERT_TRUE(wait_until([&] { return map() == nullptr; }));
  EXPECT_EQ(input_->missing(), text_of(Reason::kLocalMapSilent));
}

TEST_F(MapInputOverDds, WithBothTheObstaclesOfEitherCount) {
  listen({.slice = {}, .fixtures = {}, .map_source = "both", .local_timeout = 60.0});
  EXPECT_STREQ(input_->missing_topic(), "octomap_binary");
  publisher_->publish(wall("map"));
  octomap::OcTree behind(0.05);
  behind.updateNode(-0.99, 0.01, 0.3, true);
  auto seen = wall("map");
  seen.data(encode_octomap(behind));
  const auto local = server_.create_publisher(topics::octomap_local);
  EXPECT_TRUE(wait_until([&] {
    local.publish(seen);
    return has_wall() && map()->distance({-0.98, 0.02}) == 0.0;
  }));
}

TEST_F(MapInputOverDds, AGridFromSlamServesAsTheStaticMap) {
  listen({.slice = {}, .fixtures = {}, .static_map = "grid"});
  EXPECT_STREQ(input_->missing_topic(), "map");
  nav_msgs::msg::OccupancyGrid grid;
  grid.header(header({}, "map"));
  grid.info().resolution(0.05F);
  grid.info().width(60);
  grid.info().height(60);
  grid.info().origin().position().x(-1.5);
  grid.info().origin().position().y(-1.5);
  grid.info().origin().orientation().w(1.0);
  grid.data(std::vector<std::int8_t>(3600, 0));
  for (const std::size_t row : {29, 30}) grid.data()[row * 60 + 48] = 100;  // at (0.92, 0)
  const auto slam = server_.create_publisher(topics::map);
  slam.publish(grid);
  EXPECT_TRUE(wait_until([&] { return has_wall(); }));
}

}  // namespace
}  // namespace tandem::test
