// SPDX-License-Identifier: Apache-2.0
extern "C" const char tandem_version[] = TANDEM_TEST_VERSION;
