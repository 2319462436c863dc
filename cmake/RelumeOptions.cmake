# Compiler settings, in one interface target that every target of ours links.

set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)

find_program(CCACHE ccache)
if(CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
endif()

add_library(relume_options INTERFACE)
target_compile_features(relume_options INTERFACE cxx_std_20)
target_include_directories(relume_options INTERFACE ${CMAKE_SOURCE_DIR})
target_compile_options(relume_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Werror
  # No fast-math. These two only drop errno and floating-point traps, which nothing here reads;
  # contraction is off so that every instruction set rounds as the source says.
  -fno-math-errno -fno-trapping-math -ffp-contract=off)

if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  # What GCC needs captured, a vector that is no constant, is one where the kernels are scalar.
  target_compile_options(relume_options INTERFACE -Wno-unused-lambda-capture)
endif()

if(RELUME_SANITIZE)
  target_compile_options(relume_options INTERFACE -fsanitize=${RELUME_SANITIZE}
    -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_compile_definitions(relume_options INTERFACE RELUME_SANITIZED)
  target_link_options(relume_options INTERFACE -fsanitize=${RELUME_SANITIZE})
endif()
