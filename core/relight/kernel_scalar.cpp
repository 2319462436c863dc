#define RELUME_ISA scalar
#include "core/relight/kernel_body.h"
