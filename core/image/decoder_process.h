#pragma once

#include <memory>

#include "core/image/image_input.h"

namespace relume {

/// Opens an image of a format whose library is not trusted in a process of its own, relume-decode:
/// a file that crashes the library, or makes it ask for more than 4 GiB or a minute of processor
/// time, is an Error(input) or Error(limit) like any other. That program may write no file. It is
/// looked for in libexec/relume beside and above the program or library that this is built into,
/// and stays for the next image. What it sends is checked as a file's contents are.
std::unique_ptr<ImageInput> open_in_decoder(const ImageSource& source);

/// relume-decode's main. Standard input is a socket: for each image it is told the file and who
/// asks for it, sends the header, is told the type of values, and sends rows.
int run_decoder();

}  // namespace relume
