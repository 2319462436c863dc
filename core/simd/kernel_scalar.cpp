#define RELUME_ISA scalar
#include "core/simd/dot_products_body.h"
#include "core/simd/row_kernels_body.h"
