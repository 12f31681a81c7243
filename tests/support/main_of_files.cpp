// SPDX-License-Identifier: Apache-2.0
// main() of a program with the tests of several files. `<program> kill_test` runs those of
// kill_test.cpp only, whatever --gtest_filter says; without a name all tests run.
#include <gtest/gtest.h>

#include <filesystem>
#include <iostream>
#include <string>

namespace {

std::string tests_of(const std::string& file) {
  std::string filter;
  const ::testing::UnitTest& all = *::testing::UnitTest::GetInstance();
  for (int i = 0; i < all.total_test_suite_count(); ++i) {
    const ::testing::TestSuite& suite = *all.GetTestSuite(i);
    for (int k = 0; k < suite.total_test_count(); ++k) {
      const ::testing::TestInfo& test = *suite.GetTestInfo(k);
      if (std::filesystem::path{test.file()}.stem() != file) continue;
      filter += std::string{suite.name()} + "." + test.name() + ":";
    }
  }
  return filter;
}

}  // namespace

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  if (argc > 1) {
    const std::string filter = tests_of(argv[1]);
    if (filter.empty()) {
      std::cerr << "No test is defined in a file named " << argv[1] << ".cpp\n";
      return 2;
    }
    ::testing::GTEST_FLAG(filter) = filter;
  }
  return RUN_ALL_TESTS();
}
