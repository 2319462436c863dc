#pragma once

#include <filesystem>

#include "core/scene/io/indexed_mesh.h"

namespace relume {

/// Reads a PLY file, ascii or binary of either byte order (Turk, "The PLY polygon file format",
/// 1994): of vertices x, y, z, nx, ny, nz and u, v (or s, t), of faces the list vertex_indices (or
/// vertex_index), whose polygons are cut into fans. Other elements and properties are passed over.
/// Counts are checked against the file's size before anything is allocated. Throws Error(input) or
/// Error(limit) that names the file and the element.
IndexedMesh read_ply(const std::filesystem::path& path);

}  // namespace relume
