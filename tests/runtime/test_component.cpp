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

class Doubler {
 public:
  explicit Doubler(rt::Node& node)
      : params_{node.declare_parameters<DoublerParams>()},
        out_{node.create_publisher(rt::Topic<Float64>{"out"})},
        in_{node.create_subscription(rt::Topic<Float64>{"in"}, [this](const Float64& message) {
          Float64 product;
          product.data(params_->factor * message.data());
          out_.publish(product);
        })} {}

 private:
  rt::Parameters<DoublerParams> params_;
  rt::Publisher<Float64> out_;
  rt::Subscription in_;
};

}  // namespace
}  // namespace tandem

TANDEM_COMPONENT(tandem::Doubler, "test_component")
