// What a judgement must say where it passes or fails.
#pragma once

#include "host/commission/record/step_result.hpp"

#include "tests/support/string_from.hpp"

namespace strobe::commission_test {

inline void passes(const commission::StepResult& result) {
  CHECK_TEXT(result.state == commission::StepState::passed, result.words.c_str());
}
/// `tell`: of the advice, what would tell.
inline void is_not_told(const std::string& tell, const commission::StepResult& result) {
  CHECK_TEXT(result.state == commission::StepState::not_told, result.words.c_str());
  CHECK_EQUAL("", result.fault);
  CHECK_TEXT(result.advice.starts_with("its interval reaches over a limit: " + tell), result.advice.c_str());
}
inline void fails(const char* fault, const commission::StepResult& result) {
  CHECK_TEXT(result.state == commission::StepState::failed, result.words.c_str());
  CHECK_EQUAL(fault, result.fault);
  CHECK(!result.advice.empty());
  CHECK(result.value.has_value());
}

}  // namespace strobe::commission_test
