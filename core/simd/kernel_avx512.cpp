#define RELUME_ISA avx512
#include "core/simd/dot_products_body.h"
#include "core/simd/row_kernels_body.h"
