// SPDX-License-Identifier: Apache-2.0
// Marks what libtandem_runtime.so exports, besides the messages. Everything else in it is hidden.
#pragma once

/// Exports a function or, in front of a class's name, all of its members.
#define TANDEM_EXPORT [[gnu::visibility("default")]]

/// Exports a part of detail/ that tests call. It is not installed.
#define TANDEM_EXPORT_FOR_TESTS TANDEM_EXPORT
