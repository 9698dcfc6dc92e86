#include "work/environment.hpp"

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace dvdx {

#if defined(__x86_64__)

namespace {
constexpr unsigned all_masked = 0x1F80;
constexpr unsigned flush_results = 0x8000;
constexpr unsigned flush_operands = 0x0040;
}  // namespace

StepEnvironment::StepEnvironment() noexcept : saved_(_mm_getcsr()) { _mm_setcsr(all_masked | flush_results | flush_operands); }
StepEnvironment::~StepEnvironment() { _mm_setcsr(static_cast<unsigned>(saved_)); }

#elif defined(__aarch64__)

namespace {
constexpr std::uint64_t flush = std::uint64_t{1} << 24;
}

StepEnvironment::StepEnvironment() noexcept {
  asm volatile("mrs %0, fpcr" : "=r"(saved_));
  asm volatile("mrs %0, fpsr" : "=r"(saved_flags_));
  asm volatile("msr fpcr, %0" ::"r"(flush));
}
StepEnvironment::~StepEnvironment() {
  asm volatile("msr fpcr, %0" ::"r"(saved_));
  asm volatile("msr fpsr, %0" ::"r"(saved_flags_));
}

#else

StepEnvironment::StepEnvironment() noexcept = default;
StepEnvironment::~StepEnvironment() = default;

#endif

}  // namespace dvdx
