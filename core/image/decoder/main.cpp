// relume-decode: reads images for Relume, in a process that may crash
// (core/image/decoder_process.h).

#include "core/image/decoder_process.h"

int main() {
  return relume::run_decoder();
}
