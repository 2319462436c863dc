#include "core/simd/dot_products.h"

#include "core/simd/instruction_set.h"

namespace relume {
namespace {

using DotProducts = void (*)(const float*, int, int, const float*, int, int, int, float*, int);

DotProducts choose() {
  switch (choose_instruction_set(InstructionSet::automatic)) {
#if defined(RELUME_X86_KERNELS)
    case InstructionSet::avx512:
      return avx512::dot_products;
    case InstructionSet::avx2:
      return avx2::dot_products;
    case InstructionSet::sse42:
      return sse42::dot_products;
#endif
    default:
      return scalar::dot_products;
  }
}

}  // namespace

void dot_products(const float* a, int a_rows, int a_stride, const float* b, int b_rows,
                  int b_stride, int length, float* out, int out_stride) {
  static const DotProducts chosen = choose();
  chosen(a, a_rows, a_stride, b, b_rows, b_stride, length, out, out_stride);
}

}  // namespace relume
