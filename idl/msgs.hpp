// SPDX-License-Identifier: Apache-2.0
// In: the structures of idl/*.idl. Out: their C++ types, and how the runtime gets at their DDS
// type.
#pragma once

#include <memory>

namespace eprosima::fastdds::dds {
class TopicDataType;
}

namespace tandem::runtime {

/// What the runtime must know about message type M; one specialisation for every structure:
///
///   static constexpr const char* name = "geometry_msgs/msg/Twist";
///   static std::unique_ptr<TopicDataType> create();  // registered name …::dds_::Twist_
///
/// The type from create() refuses malformed bytes by returning false, never by throwing.
/// Services S have no MessageType of their own, but S::Request, S::Response and S::name.
template <class M>
struct MessageType;

}  // namespace tandem::runtime

#include "msgs_list.hpp"  // written by idl/CMakeLists.txt from the *.idl
