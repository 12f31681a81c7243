// SPDX-License-Identifier: Apache-2.0
// The C++ types of all structures in idl/*.idl, and the traits by which the runtime creates their
// DDS types.
#pragma once

#include <memory>

namespace eprosima::fastdds::dds {
class TopicDataType;
}

namespace tandem::runtime {

/// What the runtime needs to know about message type M; specialised for every structure:
///
///   static constexpr const char* name = "geometry_msgs/msg/Twist";
///   static std::unique_ptr<TopicDataType> create();  // registered name …::dds_::Twist_
///
/// The type from create() refuses malformed bytes by returning false, never by throwing.
/// A service S has no MessageType but provides S::Request, S::Response and S::name.
template <class M>
struct MessageType;

}  // namespace tandem::runtime

#include "msgs_list.hpp"  // written by idl/CMakeLists.txt from the *.idl
