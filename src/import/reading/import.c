// SPDX-License-Identifier: MIT
#include "import/reading/import.h"

#include "import/reading/advice.h"
#include "import/reading/text.h"

#include <assert.h>
#include <string.h>

#define PEEK_SIZE 4096 ///< enough to recognise a format

#define IMPORTER(name) extern const stp_importer stp_importer_##name;
#include "import_list.h"
#undef IMPORTER

static const stp_importer* const importers[] = {
#define IMPORTER(name) &stp_importer_##name,
#include "import_list.h"
#undef IMPORTER
    NULL,
};

const stp_importer* const* stp_importers(void)
{
    return importers;
}

static const char* base_name(const char* path)
{
    const char* slash = strrchr(path, '/');
    return slash != NULL ? slash + 1 : path;
}

static char lower_case(char c)
{
    if (c >= 'A' && c <= 'Z') {
        return (char)(c - 'A' + 'a');
    }
    return c;
}

// Whether the file's extension is one of the words, ignoring case.
static bool has_extension(const char* path, const char* words)
{
    const char* dot = strrchr(base_name(path), '.');
    if (dot == NULL || words == NULL) {
        return false;
    }
    size_t length = strlen(dot + 1);
    while (*words != '\0') {
        size_t word = strcspn(words, " ");
        size_t same = 0;
        while (same < word && same < length && lower_case(dot[1 + same]) == words[same]) {
            same += 1;
        }
        if (word == length && same == length) {
            return true;
        }
        words += word + (words[word] == ' ');
    }
    return false;
}

// By content first, then by extension, then the importers for remaining files.
static const stp_importer* find_importer(const char* path, const stp_mapped_file* file)
{
    for (int fallback = 0; fallback < 2; ++fallback) {
        for (const stp_importer* const* i = importers; *i != NULL; ++i) {
            if ((*i)->fallback == (fallback != 0) && (*i)->detect != NULL &&
                (*i)->detect(file->bytes, file->size)) {
                return *i;
            }
        }
        for (const stp_importer* const* i = importers; *i != NULL; ++i) {
            bool takes_all = fallback != 0 && (*i)->extensions == NULL;
            if ((*i)->fallback == (fallback != 0) &&
                (takes_all || has_extension(path, (*i)->extensions))) {
                return *i;
            }
        }
    }
    return NULL;
}

// Importers do not see the byte order mark of a text. @return its bytes
static size_t skip_mark(stp_mapped_file* file)
{
    size_t mark = stp_text_mark(file->bytes, file->size);
    file->bytes = mark > 0 ? file->bytes + mark : file->bytes;
    file->size -= mark;
    return mark;
}

const char* stp_importer_listed(const stp_importer* importer)
{
    const char* listed = importer->listed != NULL ? importer->listed : importer->extensions;
    return importer->title != NULL && listed != NULL ? listed : "";
}

bool stp_import_lists(const char* path)
{
    for (const stp_importer* const* i = importers; *i != NULL; ++i) {
        if (has_extension(path, stp_importer_listed(*i))) {
            return true;
        }
    }
    return false;
}

const stp_importer* stp_import_listed(size_t place)
{
    for (int fallback = 0; fallback < 2; ++fallback) {
        for (const stp_importer* const* i = importers; *i != NULL; ++i) {
            bool counts = (*i)->fallback == (fallback != 0) && *stp_importer_listed(*i) != 0;
            if (counts && place-- == 0) {
                return *i;
            }
        }
    }
    return NULL;
}

bool stp_import_takes_columns(const char* path)
{
    unsigned char bytes[PEEK_SIZE];
    stp_mapped_file start = {.bytes = bytes, .size = stp_file_peek(path, bytes, sizeof(bytes))};
    assert(start.size <= sizeof(bytes));
    (void)skip_mark(&start);
    const stp_importer* importer = find_importer(path, &start);
    return importer != NULL && importer->columns;
}

// The rotation that turns an axis to y, with a scale: about x for y and z, about z for x.
static stp_affine turn_up(char up, double s)
{
    switch (up) {
    case 'x':
        return (stp_affine){{{0, -s, 0, 0}, {s, 0, 0, 0}, {0, 0, s, 0}}};
    case 'X':
        return (stp_affine){{{0, s, 0, 0}, {-s, 0, 0, 0}, {0, 0, s, 0}}};
    case 'Y':
        return (stp_affine){{{s, 0, 0, 0}, {0, -s, 0, 0}, {0, 0, -s, 0}}};
    case 'z':
        return (stp_affine){{{s, 0, 0, 0}, {0, 0, s, 0}, {0, -s, 0, 0}}};
    case 'Z':
        return (stp_affine){{{s, 0, 0, 0}, {0, 0, -s, 0}, {0, s, 0, 0}}};
    default:
        return (stp_affine){{{s, 0, 0, 0}, {0, s, 0, 0}, {0, 0, s, 0}}};
    }
}

void stp_import_set_axes(stp_import* import, char up, double unit_metres)
{
    stp_scene* scene = import->scene;
    bool first = import->root == 0;
    assert(import->root < scene->object_count && "its root object was added");
    const stp_import_desc* desc = &import->desc;
    double unit = unit_metres > 0.0 ? unit_metres : desc->unit_metres;
    if (desc->corrects) {
        up = desc->up != 0 ? desc->up : up;
        unit = desc->unit_metres > 0.0 ? desc->unit_metres : unit;
    }
    double scale = 1.0;
    import->unit_metres = unit;
    if (first) {
        scene->unit_metres = unit;
        scene->up = up == 'z' || up == 'Z' ? "z" : up == 'x' || up == 'X' ? "x" : "y";
    } else if (scene->unit_metres == 0.0) {
        scene->unit_metres = unit; // files of unknown unit are assumed to use the known one
    } else if (unit > 0.0) {
        scale = unit / scene->unit_metres;
    }
    scene->objects[import->root].transform = turn_up(up, scale);
}

// Inputs of one scene share a unit; the user should know if it is a guess.
static void check_units(const stp_import* import, double scene_unit)
{
    const stp_scene* scene = import->scene;
    if (import->wants_unit && scene->unit_metres == 0.0) {
        stp_warn(import->context, "%s: its unit of length is unknown (set it with unit_metres)",
                 import->path);
    }
    if (scene->source_count < 2) {
        return;
    }
    if (import->unit_metres == 0.0 && scene->unit_metres > 0.0) {
        stp_warn(import->context,
                 "%s: its unit of length is unknown: assumes that of the other inputs, %g m",
                 import->path, scene->unit_metres);
    } else if (import->unit_metres > 0.0 && scene_unit == 0.0) {
        stp_warn(
            import->context,
            "%s: its unit of length is %g m: assumes the same for earlier inputs without a unit",
            import->path, import->unit_metres);
    }
}

static stp_result read_with(const stp_importer* importer, stp_import* import)
{
    stp_source source = {
        .path = import->path, .format = importer->name, .bytes = import->file.size};
    stp_object root = {
        .name = base_name(import->path), .parent = STP_NONE, .transform = stp_affine_identity()};
    stp_result result = stp_scene_add_source(import->scene, &source);
    if (result == STP_OK) {
        result = stp_scene_add_object(import->scene, &root, &import->root);
    }
    if (result != STP_OK) {
        return result;
    }
    char up = 'y';
    if (import->desc.up != 0) {
        up = import->desc.up;
    }
    double scene_unit = import->scene->unit_metres;
    assert(import->root + 1 == import->scene->object_count && "the file's objects come after it");
    stp_import_set_axes(import, up, 0.0);
    result = importer->read(import);
    if (result == STP_OK && import->desc.sample_points == 0) {
        check_units(import, scene_unit);
        stp_losses_report(import->context, import->path, &import->losses);
    }
    return result;
}

// Rejects files that a build writes; they resemble no input format (docs/format.md).
static bool is_built(const stp_mapped_file* file)
{
    static const unsigned char magic[8] = {0x89, 'S', 'T', 'P', '\r', '\n', 0x1a, '\n'};
    return file->size >= sizeof(magic) && memcmp(file->bytes, magic, sizeof(magic)) == 0;
}

static stp_result import_mapped(stp_import* import)
{
    if (is_built(&import->file)) {
        return stp_fail(import->context, STP_ERROR_UNSUPPORTED,
                        "%s: is a built file: give the models from which it was built",
                        import->path);
    }
    const stp_importer* importer = find_importer(import->path, &import->file);
    if (importer == NULL) {
        return stp_import_refuse_unknown(import);
    }
    stp_result result = stp_progress(import->context, "import", 0.0);
    return result == STP_OK ? read_with(importer, import) : result;
}

static stp_result import_marked(stp_import* import)
{
    size_t mark = skip_mark(&import->file);
    stp_result result = import_mapped(import);
    import->file.bytes = mark > 0 ? import->file.bytes - mark : import->file.bytes;
    import->file.size += mark;
    return result;
}

stp_result stp_import_file(stp_scene* scene, const char* path, const stp_import_desc* desc)
{
    stp_import import = {.context = scene->context, .scene = scene, .path = path, .desc = *desc};
    stp_result result = stp_file_map(import.context, path, &import.file);
    if (result != STP_OK) {
        return result;
    }
    result = import_marked(&import);
    stp_folder_listings_close(import.context, &import.folders);
    stp_file_unmap(&import.file);
    return result;
}

stp_result stp_import_sample(stp_scene* scene, const char* path, const stp_import_desc* desc,
                             uint64_t maximum)
{
    stp_import import = {.context = scene->context, .scene = scene, .path = path, .desc = *desc};
    stp_result result = stp_file_map(import.context, path, &import.file);
    if (result != STP_OK) {
        return result;
    }
    const stp_importer* importer = find_importer(path, &import.file);
    import.desc.sample_points = maximum;
    if (importer != NULL && importer->samples) {
        result = read_with(importer, &import);
    }
    stp_folder_listings_close(import.context, &import.folders);
    stp_file_unmap(&import.file);
    return result;
}

stp_result stp_import_memory(stp_scene* scene, const char* name, const void* bytes, size_t size,
                             const stp_import_desc* desc)
{
    assert(bytes != NULL || size == 0);
    stp_import import = {.context = scene->context,
                         .scene = scene,
                         .path = name,
                         .file = {.bytes = bytes, .size = size},
                         .desc = *desc,
                         .alone = true};
    return import_marked(&import);
}
