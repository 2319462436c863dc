#define RELUME_ISA avx2
#include "core/simd/dot_products_body.h"
#include "core/simd/row_kernels_body.h"
