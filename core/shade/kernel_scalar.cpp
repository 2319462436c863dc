#define RELUME_ISA scalar
#include "core/shade/lobe_kernel_body.h"
