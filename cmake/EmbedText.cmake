# embed_text(OUTPUT HEADER TYPE VARIABLE FILE...): writes a C++ source that defines
# `const relume::TYPE relume::VARIABLE`, an aggregate of string views of the files' texts in order.
function(embed_text output header type variable)
  set(members "")
  foreach(file ${ARGN})
    file(READ "${file}" text)
    string(FIND "${text}" ")relume_text\"" found)
    if(NOT found EQUAL -1)
      message(FATAL_ERROR "${file}: holds the mark that ends embedded text")
    endif()
    string(APPEND members "    R\"relume_text(${text})relume_text\",\n")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${file}")
  endforeach()
  file(WRITE "${output}.new" "#include \"${header}\"\n\nnamespace relume {\n\n"
    "extern const ${type} ${variable};\nconst ${type} ${variable}{\n${members}};\n\n}  // namespace relume\n")
  configure_file("${output}.new" "${output}" COPYONLY)
endfunction()
