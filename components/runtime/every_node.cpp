// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/every_node.hpp"

namespace tandem::runtime::every_node {

Interface interface() {
  return {.subscribes = {{clock, "use_sim_time: true"}},
          .publishes = {rosout,
                        parameter_events,
                        {diagnostics, "the network's guard drops a datagram"}},
          .serves = {{describe_parameters, kParameters},
                     {get_parameter_types, kParameters},
                     {get_parameters, kParameters},
                     {list_parameters, kParameters},
                     {set_parameters, kParameters},
                     {set_parameters_atomically, kParameters},
                     get_logger_levels,
                     set_logger_levels,
                     get_type_description}};
}

}  // namespace tandem::runtime::every_node
