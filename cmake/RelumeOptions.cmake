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

# Of these source files of the calling folder, what sanitizers must leave alone.
function(relume_limit_sanitizers)
  foreach(source ${ARGN})
    if(RELUME_SANITIZE MATCHES "thread" AND source MATCHES "base/parallel\\.cpp$")
      # oneTBB is not instrumented: parallel.cpp tells ThreadSanitizer its edges instead (see there).
      set_source_files_properties(${source} PROPERTIES COMPILE_OPTIONS "-fno-sanitize=thread"
        COMPILE_DEFINITIONS RELUME_TSAN)
    elseif(RELUME_SANITIZE MATCHES "address" AND source MATCHES "kernel_[a-z0-9]+\\.cpp$")
      # Where a kernel's many short-lived vectors end is not watched: GCC would take ten times as long.
      set_property(SOURCE ${source} APPEND PROPERTY
        COMPILE_OPTIONS -fno-sanitize-address-use-after-scope)
    endif()
  endforeach()
endfunction()
