// SPDX-License-Identifier: MIT
//
// Reads files into a scene. A format is one file format_NAME.c that defines `const stp_importer
// stp_importer_NAME`; the build finds it (CMake writes the list), and nothing else changes.
#pragma once

#include "base/io/file.h"
#include "import/reading/losses.h"
#include "import/reading/similar_path.h"
#include "scene/scene.h"

typedef struct stp_import_desc {
    /// Up axis if the input does not specify it: 'x', 'y' or 'z', or 'X', 'Y' or 'Z' for the
    /// negative axis; default: the format's convention
    char up;
    double unit_metres; ///< length of one input unit, if the input does not specify it; 0: unknown
    /// `up` and `unit_metres`, where set, replace what the input specifies.
    bool corrects;
    /// Columns of point texts: "x,y,z,r,g,b,intensity,nx,ny,nz,class,-" in any order; NULL:
    /// detected from the header, or from number and values
    const char* columns;
    /// Above 0: meshes without normals get smooth ones across edges up to this angle, in degrees,
    /// at most 180 (import/reading/smooth.h)
    double smooth_degrees;
    /// Not NULL: point formats with a header describe it here. If that is all (`alone`), as for
    /// LAS, no points are read; PCD and E57 read them as usual.
    struct stp_scan_info* scan;
    /// Not 0: reads about this many points from all over the file, without warnings; see
    /// stp_import_sample.
    uint64_t sample_points;
    /// Memory limit of the child process that reads foreign formats; default 4 GiB.
    uint64_t helper_memory_bytes;
    /// Its time limit. 0: 600 s of wall-clock time, and 30 s of CPU time plus 1 s for each 10,000
    /// bytes that are read.
    uint32_t helper_seconds;
} stp_import_desc;

/// One file being read, into `scene`. All objects of the file belong below `root`, which is named
/// after the file and converts its axes (set by stp_import_set_axes).
typedef struct stp_import {
    stp_context* context;
    stp_scene* scene;
    const char* path; ///< as given; messages begin with it
    stp_mapped_file file;
    stp_import_desc desc;
    uint32_t root;
    double unit_metres; ///< length of the file's unit, once its axes are set; 0: unknown
    bool wants_unit;    ///< warn if the unit is not known
    stp_losses losses;  ///< content that is not kept; reported after reading
    uint64_t picture_pixels, picture_bytes; ///< sums over all pictures read so far
    stp_folder_listings folders;            ///< in which references were searched
    bool alone; ///< the bytes came from memory: no file beside it may be read
} stp_import;

typedef struct stp_importer {
    const char* name;       ///< as `info` prints it: "gltf"
    const char* extensions; ///< lower case, separated by spaces: "gltf glb"
    const char* title;      ///< name for people: "glTF 2.0"; NULL: it only refuses
    /// Extensions that lists of files show; NULL: `extensions`. Others of these mostly have other
    /// content, such as "txt".
    const char* listed;
    /// Whether the content has this format, by its first bytes; NULL: decided by extension only.
    bool (*detect)(const unsigned char* bytes, size_t size);
    /// Reads the file. On failure the message is already logged; the caller destroys the scene.
    stp_result (*read)(stp_import* import);
    bool samples; ///< supports desc.sample_points
    bool columns; ///< supports desc.columns
    /// Tried last, on files that no other importer claims. If `extensions` is not NULL, it must
    /// contain the file's, or `detect` must recognise the content.
    bool fallback;
} stp_importer;

/// Reads one file into the scene (before stp_scene_finish). The format is found by content, then by
/// extension. Several files form one scene: its unit is the first known one, the others are scaled
/// to it, and a file without a unit is assumed to use it, with a warning. @return STP_OK;
/// STP_ERROR_IO, STP_ERROR_TRUNCATED, STP_ERROR_FORMAT, STP_ERROR_UNSUPPORTED, STP_ERROR_LIMIT,
/// STP_ERROR_OUT_OF_MEMORY, STP_ERROR_CANCELLED, each with one logged sentence that names file and
/// location
STP_MUST_USE stp_result stp_import_file(stp_scene* scene, const char* path,
                                        const stp_import_desc* desc);

/// Reads a file from memory; `name` replaces its path and provides the extension. References to
/// other files are rejected.
STP_MUST_USE stp_result stp_import_memory(stp_scene* scene, const char* name, const void* bytes,
                                          size_t size, const stp_import_desc* desc);

/// For a first picture: reads about `maximum` points spread over a file that has at least four
/// times as many, much faster than the whole file. The scene stays empty if the format does not
/// support this or the file is smaller. @return as stp_import_file
STP_MUST_USE stp_result stp_import_sample(stp_scene* scene, const char* path,
                                          const stp_import_desc* desc, uint64_t maximum);

/// Whether desc.columns applies to a file: its importer reads texts of points. Decided by the path
/// and the first bytes; the file may be missing.
bool stp_import_takes_columns(const char* path);

/// Extensions of an importer that lists of files show, separated by spaces; "" if it only refuses.
const char* stp_importer_listed(const stp_importer* importer);
/// Whether a file with this name is a model, by its extension: an importer lists it.
bool stp_import_lists(const char* path);

/// The importers that list extensions, in the order for people: those of many formats last. @return
/// NULL if there is no importer `place`
const stp_importer* stp_import_listed(size_t place);

/// All importers, NULL at the end. Files that none of them claims go to assimp, if the build
/// includes it.
const stp_importer* const* stp_importers(void);

// For importers:

/// Sets the up axis of the file (as stp_import_desc.up) and the length of its unit (0: not
/// specified, so desc.unit_metres applies), before objects are added. With desc.corrects, what is
/// set there replaces both. A format without an axis
/// passes desc.up if it is set, else its usual axis. Without a call: desc.up or 'y',
/// desc.unit_metres.
void stp_import_set_axes(stp_import* import, char up, double unit_metres);

/// The path of a file that `reference` (a relative URI or path, already percent-decoded) names,
/// relative to the imported file's folder. Rejects absolute paths, drive letters, URLs and ".."
/// that leave the folder. Backslashes count as slashes. If there is no such file, one may be found
/// whose name differs in case, or lacks a query ("?v=1"). @return STP_OK with an arena copy (of the
/// scene's text arena), STP_ERROR_FORMAT or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_import_resolve(stp_import* import, const char* reference,
                                           const char** path);

/// Same, for an optional file such as a picture: if the reference is rejected or the file does not
/// exist, `path` becomes NULL after a warning that begins with `place`. @return STP_OK or
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_import_resolve_optional(stp_import* import, const char* place,
                                                    const char* reference, const char** path);
