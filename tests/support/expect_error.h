#pragma once

#include <gtest/gtest.h>

#include <string>

#include "core/base/error.h"

/// Expects `statement` to throw relume::Error of kind `expected_kind` whose text contains `part`.
#define EXPECT_ERROR(statement, expected_kind, part)                                      \
  do {                                                                                    \
    try {                                                                                 \
      statement;                                                                          \
      ADD_FAILURE() << "no Error was thrown, expected: " << (part);                       \
    } catch (const relume::Error& error) {                                                \
      EXPECT_EQ(error.kind(), expected_kind) << error.what();                             \
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what(); \
    }                                                                                     \
  } while (0)
