#define RELUME_ISA scalar
#include "core/simd/dot_products_body.h"
