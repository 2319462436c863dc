#include "viewer/commands/commands.h"

int main(int argc, char** argv) {
  return relume::run_command_line(argc, argv);
}
