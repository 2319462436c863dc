#define RELUME_ISA avx512
#include "core/shade/lobe_kernel_body.h"
