// SPDX-License-Identifier: Apache-2.0
// libtandem_test_component.so: doubles the messages of `in` and publishes them on `out`.
#include "tandem/runtime/component.hpp"

namespace tandem {
namespace {

using std_msgs::msg::Float64;

struct DoublerParams {
  double factor = 2.0;

  template <class Visitor>
  void visit(Visitor&& field) {
    field("factor", factor, Range{0.0, 10.0}, "what inputs are multiplied with");
  }
};

constexpr rt::Topic<Float64> kIn{"in"}, kOut{"out", rt::kLatched};

class Doubler {
 public:
  using Params = DoublerParams;

  explicit Doubler(rt::Node& node)
      : params_{node.declare_parameters<Params>()},
        out_{node.create_publisher(kOut)},
        in_{node.create_subscription(kIn, [this](const Float64& message) {
          Float64 product;
          product.data(params_->factor * message.data());
          out_.publish(product);
        })} {}
  static rt::Interface interface() { return {.subscribes = {kIn}, .publishes = {kOut}}; }

 private:
  rt::Parameters<DoublerParams> params_;
  rt::Publisher<Float64> out_;
  rt::Subscription in_;
};

}  // namespace
}  // namespace tandem

TANDEM_COMPONENT(tandem::Doubler, "test_component")
