# Finds every dependency, each with the Debian package that provides it.

include(CheckIncludeFileCXX)
find_package(PkgConfig REQUIRED)

macro(relume_find package debian_package)
  find_package(${package} ${ARGN} QUIET)
  if(NOT ${package}_FOUND)
    message(FATAL_ERROR "${package} not found: apt-get install ${debian_package}")
  endif()
endmacro()

macro(relume_find_pkg target module debian_package)
  pkg_check_modules(${target} QUIET IMPORTED_TARGET ${module})
  if(NOT ${target}_FOUND)
    message(FATAL_ERROR "${module} not found: apt-get install ${debian_package}")
  endif()
endmacro()

relume_find(embree libembree-dev 3)
relume_find(TBB libtbb-dev)
relume_find(glm libglm-dev)
relume_find(fmt libfmt-dev)
relume_find(CLI11 libcli11-dev)
relume_find(nlohmann_json nlohmann-json3-dev)
relume_find(tinyobjloader libtinyobjloader-dev)
relume_find(OpenImageIO libopenimageio-dev)
relume_find_pkg(xxhash libxxhash libxxhash-dev)

# Debian's OpenImageIO names an OpenCV include folder that its package does not install.
foreach(target OpenImageIO::OpenImageIO OpenImageIO::OpenImageIO_Util)
  get_target_property(includes ${target} INTERFACE_INCLUDE_DIRECTORIES)
  list(FILTER includes EXCLUDE REGEX opencv)
  set_target_properties(${target} PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${includes}")
endforeach()

if(RELUME_VIEWER)
  relume_find(glfw3 libglfw3-dev 3.3)
  relume_find_pkg(imgui imgui libimgui-dev)
  relume_find_pkg(osmesa osmesa libosmesa6-dev)
endif()
if(RELUME_TESTS)
  relume_find(GTest libgtest-dev)
endif()
