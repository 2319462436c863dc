# Tests of the sanitized builds alone.

# Faults put in, which a sanitized build must report, and loops without one, of which it must not.
function(test_injected_faults library)
  add_executable(injected_fault reliability/injected_fault.cpp)
  target_link_libraries(injected_fault PRIVATE ${library})
  function(expect_report name fault report)
    add_test(NAME Sanitizers.${name} COMMAND injected_fault ${fault})
    set_tests_properties(Sanitizers.${name} PROPERTIES PASS_REGULAR_EXPRESSION "${report}")
  endfunction()
  if(RELUME_SANITIZE MATCHES "thread")
    expect_report(FindAnInjectedRace race "WARNING: ThreadSanitizer: data race")
  else()
    expect_report(FindAReadBeyondTheEnd beyond "AddressSanitizer: heap-buffer-overflow")
    expect_report(FindALeak leak "LeakSanitizer: detected memory leaks")
    expect_report(FindACastThatOverflows cast "outside the range of representable values")
    expect_report(FindADivisionByZero divide "runtime error: division by zero")
  endif()
  add_test(NAME Sanitizers.SayNothingWhereThereIsNoFault COMMAND injected_fault none)
endfunction()

# What ./dev short builds, many files at once: all between a scene and its frame but files, pictures and vector
# kernels, with the tests of what runs on several threads or has many buffers.
function(relume_short_tests)
  set(folders core/base core/math core/simd core/shade core/samples core/trace core/relight core/scene
    core/scene/procedural shadow reduction reduction/methods)
  list(TRANSFORM folders PREPEND ${CMAKE_SOURCE_DIR}/)
  list(TRANSFORM folders APPEND /*.cpp)
  file(GLOB sources CONFIGURE_DEPENDS ${folders})
  list(FILTER sources EXCLUDE REGEX "kernel_(sse42|avx2|avx512)\\.cpp$")
  add_library(relume_short STATIC ${sources})
  target_link_libraries(relume_short PUBLIC relume_options fmt::fmt glm::glm
    PRIVATE embree TBB::tbb PkgConfig::xxhash ZLIB::ZLIB)
  relume_limit_sanitizers(${sources})
  set_target_properties(relume_short PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 30)
  target_compile_options(relume_short PRIVATE -w)  # names of one file shadow those of another
  # Names that other files have too.
  list(APPEND apart core/relight/kernel_scalar.cpp core/samples/sample_scene.cpp reduction/methods/kmedoids.cpp
    shadow/light_plane.cpp)
  list(TRANSFORM apart PREPEND ${CMAKE_SOURCE_DIR}/)
  set_source_files_properties(${apart} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  test_injected_faults(relume_short)

  file(GLOB support_sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/support/*.cpp)
  add_executable(test_short core/base_parallel_test.cpp core/procedural_hair_ball_test.cpp
    core/relight_drag_test.cpp core/relight_extremes_test.cpp core/relight_pixel_visibility_test.cpp
    core/samples_corrupt_cache_test.cpp core/trace_tracer_test.cpp reduction/reduction_tile_test.cpp
    shadow/shadow_approximators_test.cpp shadow/shadow_members_test.cpp ${support_sources})
  target_link_libraries(test_short PRIVATE relume_short GTest::gtest_main)
  add_test(NAME Sanitizers.FindNothingBetweenASceneAndItsFrame COMMAND test_short --gtest_brief=1)
  set_tests_properties(Sanitizers.FindNothingBetweenASceneAndItsFrame PROPERTIES TIMEOUT 600)
endfunction()
