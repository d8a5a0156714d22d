// SPDX-License-Identifier: MIT
//
// Exact CAD formats, which describe surfaces instead of triangles: rejected with advice.
#include "import/reading/import.h"

#include <assert.h>
#include <string.h>

enum {
    SCHEMA_SEARCHED = 1 << 14, ///< bytes of a STEP file within which its header names its schema
    IGES_LINE = 80,            ///< bytes of an IGES record; byte 72 names its section
};

static const char step_start[] = "ISO-10303-21;";

static bool contains(const unsigned char* bytes, size_t size, const char* word)
{
    assert(word[0] != '\0' && "it would be contained in everything");
    size_t length = strlen(word);
    for (size_t at = 0; at + length <= size; ++at) {
        if (memcmp(bytes + at, word, length) == 0) {
            return true;
        }
    }
    return false;
}

static bool is_step(const unsigned char* bytes, size_t size)
{
    size_t length = sizeof(step_start) - 1;
    size_t searched = size < SCHEMA_SEARCHED ? size : SCHEMA_SEARCHED;
    // IFC uses the same container, and is supported
    return size >= length && memcmp(bytes, step_start, length) == 0 &&
           !contains(bytes, searched, "'IFC");
}

static bool is_iges(const unsigned char* bytes, size_t size)
{
    return size > IGES_LINE && memcmp(bytes + 72, "S      1", 8) == 0 &&
           (bytes[IGES_LINE] == '\n' || bytes[IGES_LINE] == '\r');
}

static bool detect(const unsigned char* bytes, size_t size)
{
    return is_step(bytes, size) || is_iges(bytes, size);
}

static stp_result refuse(stp_import* import)
{
    const char* dot = strrchr(import->path, '.');
    bool iges = is_iges(import->file.bytes, import->file.size) ||
                (dot != NULL && (dot[1] == 'i' || dot[1] == 'I'));
    return stp_fail(
        import->context, STP_ERROR_UNSUPPORTED,
        "%s: is %s, which contains exact surfaces instead of triangles and is not supported: "
        "export glTF, OBJ or STL from the CAD program, or convert it, for example with "
        "FreeCAD",
        import->path, iges ? "IGES" : "STEP");
}

const stp_importer stp_importer_cad = {
    .name = "cad", .extensions = "stp step p21 stpz igs iges", .detect = detect, .read = refuse};
