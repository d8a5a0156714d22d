// SPDX-License-Identifier: MIT
//
// Descriptions of LAS files without reading points, and the sample for a first picture.
#include "las_points.h"

#include "import/las/las.h"
#include "import/las/laz.h"

enum { COUNT = 9000 };

static las_point points[COUNT];

static bool same_identity(const char* text, const char* name, uint32_t epsg)
{
    stp_system_identity found = stp_system_identify(text);
    return strcmp(found.name, name) == 0 && found.epsg == epsg;
}

void test_scan_systems_are_identified(test_state* test)
{
    static const char projected[] =
        "PROJCS[\"NAD83 / UTM zone "
        "10N\",GEOGCS[\"NAD83\",DATUM[\"d\",AUTHORITY[\"EPSG\",\"6269\"]],"
        "AUTHORITY[\"EPSG\",\"4269\"]],UNIT[\"metre\",1,AUTHORITY[\"EPSG\",\"9001\"]],"
        "AUTHORITY[\"EPSG\",\"26910\"]]";
    static const char compound[] =
        "COMPD_CS[\"both\", PROJCS [\"plane\",GEOGCS[\"g\",AUTHORITY[\"EPSG\",\"4269\"]],"
        "AUTHORITY[\"EPSG\",\"2994\"]],VERT_CS[\"h\",AUTHORITY[\"EPSG\",\"5703\"]]]";
    CHECK(same_identity(projected, "NAD83 / UTM zone 10N", 26910));
    CHECK(same_identity(compound, "both", 2994));
    CHECK(same_identity("PROJCRS[\"new\",BASEGEOGCRS[\"b\",ID[\"EPSG\",4326]],ID[\"EPSG\",2154]]",
                        "new", 2154));
    // the code of a component is not the system's own
    CHECK(same_identity("PROJCS[\"own\",GEOGCS[\"g\",AUTHORITY[\"EPSG\",\"4269\"]]]", "own", 0));
    CHECK(same_identity("PROJCS[\"AUTHORITY[x]\",AUTHORITY[\"ESRI\",\"102100\"]]", "AUTHORITY[x]",
                        0));
    CHECK(same_identity("EPSG:25832", "", 25832) && same_identity(NULL, "", 0));
    char text[sizeof(compound)];
    for (size_t cut = 0; cut < sizeof(compound); ++cut) { // parsing ends for any truncation
        memcpy(text, compound, sizeof(text));
        text[cut] = '\0';
        CHECK(strlen(stp_system_identify(text).name) < sizeof(compound));
    }
    memset(text, '[', sizeof(text) - 1);
    CHECK(same_identity(text, "", 0));
}

static stp_scene* read_as(stp_context* context, const las_buffer* file, const stp_import_desc* desc)
{
    stp_scene* scene = NULL;
    bool good = stp_scene_create(context, &scene) == STP_OK &&
                stp_import_memory(scene, "a.laz", file->bytes, file->size, desc) == STP_OK;
    if (!good) {
        stp_scene_destroy(scene);
    }
    return good ? scene : NULL;
}

static const stp_scan_field* field_named(const stp_scan_info* info, const char* name)
{
    for (uint32_t i = 0; i < info->field_count; ++i) {
        if (strcmp(info->fields[i].name, name) == 0) {
            return &info->fields[i];
        }
    }
    return NULL;
}

static bool header_is_right(const las_desc* desc)
{
    las_buffer file = las_write(desc);
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scan_info info;
    stp_scene* scene = read_as(context, &file, &(stp_import_desc){.scan = &info});
    bool compressed = desc->coding != LAS_RAW;
    bool good = scene != NULL && scene->point_set_count == 0 && info.alone &&
                info.point_count == desc->count && info.point_format == (int)desc->format &&
                info.compressed == compressed && !info.copc &&
                info.record_bytes == las_record_size(desc) && info.scale[0] == 0.01;
    good = good && (!compressed ||
                    (info.chunk_count == (desc->count + 999) / 1000 && info.chunk_points == 1000));
    good = good && (field_named(&info, "time") != NULL) == (desc->format != 0 && desc->format != 2);
    const stp_scan_field* extra = good ? field_named(&info, "undocumented") : NULL;
    good = good && (extra != NULL ? extra->extra && !extra->kept && extra->count == desc->extra
                                  : desc->extra == 0);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    free(file.bytes);
    return good;
}

void test_las_headers_tell_without_points(test_state* test)
{
    for (unsigned format = 0; format <= 10; ++format) {
        las_make_points(points, 3000, format, format);
        las_desc desc = {.points = points,
                         .count = 3000,
                         .format = format,
                         .extra = format % 3,
                         .coding = format % 2 != 0 ? LAS_RAW : LAZ_CHUNKED,
                         .chunk_size = 1000};
        CHECK(header_is_right(&desc));
    }
    unsigned char documented[2 * 192] = {0};
    documented[2] = 4;        // a signed 16-bit number
    documented[192 + 2] = 29; // three floats
    memcpy(documented + 4, "Amplitude", 9);
    memcpy(documented + 192 + 4, "A name that takes all 32 bytes!!", 32);
    las_desc desc = {.points = points,
                     .count = 10,
                     .format = 7,
                     .extra = 15,
                     .vlr_user = "LASF_Spec",
                     .vlr_id = 4,
                     .vlr = documented,
                     .vlr_size = sizeof(documented)};
    las_buffer file = las_write(&desc);
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scan_info info;
    stp_scene* scene = read_as(context, &file, &(stp_import_desc){.scan = &info});
    CHECK(scene != NULL);
    const stp_scan_field *first = field_named(&info, "Amplitude"),
                         *second = field_named(&info, "A name that takes all 32 bytes!!"),
                         *rest = field_named(&info, "undocumented");
    CHECK(first != NULL && strcmp(first->type, "i16") == 0 && first->count == 1);
    CHECK(second != NULL && strcmp(second->type, "f32") == 0 && second->count == 3);
    CHECK(rest != NULL && rest->count == 1);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    free(file.bytes);
}

// Whether each point of the sample is one of the file's, in order.
static bool is_sample(const stp_scene* sample, const stp_scene* whole, uint32_t minimum,
                      uint32_t maximum)
{
    if (sample == NULL || sample->point_set_count != 1 || whole->point_set_count != 1) {
        return false;
    }
    const stp_point_set *s = &sample->point_sets[0], *w = &whole->point_sets[0];
    uint32_t at = 0;
    for (uint32_t i = 0; i < s->point_count; ++i, ++at) {
        while (at < w->point_count &&
               (memcmp(s->positions + 3 * i, w->positions + 3 * at, 12) != 0 ||
                memcmp(s->colors + 4 * i, w->colors + 4 * at, 4) != 0)) {
            ++at;
        }
        if (at == w->point_count) {
            return false;
        }
    }
    return s->point_count >= minimum && s->point_count <= maximum && at > w->point_count / 2;
}

static bool sample_is_right(const las_desc* desc, uint64_t wanted, uint32_t minimum,
                            uint32_t maximum)
{
    las_buffer file = las_write(desc);
    test_log log = {0};
    stp_context* context = test_context(NULL, 2, NULL);
    stp_context* heard = test_context(NULL, 2, &log);
    stp_scene* whole = read_as(context, &file, &(stp_import_desc){0});
    stp_scene* sample = read_as(heard, &file, &(stp_import_desc){.sample_points = wanted});
    bool good = whole != NULL && is_sample(sample, whole, minimum, maximum) && log.warnings == 0;
    stp_scene_destroy(sample);
    sample = read_as(heard, &file, &(stp_import_desc){.sample_points = desc->count / 3});
    good = good && sample != NULL && sample->point_set_count == 0; // too small for a sample
    stp_scene_destroy(sample);
    stp_scene_destroy(whole);
    stp_context_destroy(context);
    stp_context_destroy(heard);
    free(file.bytes);
    return good;
}

void test_las_samples_are_from_all_over_the_file(test_state* test)
{
    las_make_points(points, COUNT, 7, 3);
    las_desc desc = {.points = points, .count = COUNT, .format = 7, .chunk_size = 1000};
    CHECK(sample_is_right(&desc, 1000, 1000, 1088));
    desc.coding = LAZ_CHUNKED;
    CHECK(sample_is_right(&desc, 1800, 1800, 1800));
    desc.coding = LAZ_VARIABLE;
    desc.chunk_size = 50;
    CHECK(sample_is_right(&desc, 1000, 500, 1500));
    las_make_points(points, COUNT, 2, 3);
    desc = (las_desc){
        .points = points, .count = COUNT, .format = 2, .coding = LAZ_CHUNKED, .chunk_size = 500};
    CHECK(sample_is_right(&desc, 1000, 1000, 1200));
}

// The offsets of the chunks of a file.
static bool find_chunks(const las_buffer* file, size_t count, uint64_t* places)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_import import = {
        .context = context, .path = "a.laz", .file = {.bytes = file->bytes, .size = file->size}};
    stp_las las = {.import = &import, .context = context};
    bool good = stp_las_read_header(&las) == STP_OK && stp_laz_read_table(&las) == STP_OK &&
                las.chunk_count == count;
    for (size_t i = 0; i < count && good; ++i) {
        places[i] = las.chunks[i].offset;
    }
    stp_free(context, las.chunks);
    stp_context_destroy(context);
    return good;
}

// For COPC, whole levels: here the first one, which is the fifth chunk of nine.
void test_las_samples_of_copc_are_coarse_levels(test_state* test)
{
    enum { CHUNKS = 9 };
    static const uint32_t levels[CHUNKS] = {1, 2, 2, 2, 0, 2, 2, 2, 1};
    unsigned char vlr[160 + CHUNKS * 32] = {0};
    las_make_points(points, COUNT, 7, 5);
    las_desc desc = {.points = points,
                     .count = COUNT,
                     .format = 7,
                     .coding = LAZ_CHUNKED,
                     .chunk_size = COUNT / CHUNKS,
                     .vlr_user = "copc",
                     .vlr_id = 1,
                     .vlr = vlr,
                     .vlr_size = sizeof(vlr)};
    uint64_t places[CHUNKS];
    las_buffer file = las_write(&desc);
    CHECK(find_chunks(&file, CHUNKS, places));
    free(file.bytes);
    las_buffer b = {.bytes = vlr, .capacity = sizeof(vlr), .size = 40};
    las_put_number(&b, 375 + 54 + 160, 8);
    las_put_number(&b, CHUNKS * 32, 8);
    b.size = 160;
    for (size_t i = 0; i < CHUNKS; ++i) {
        las_put_number(&b, levels[i], 4);
        b.size += 12;
        las_put_number(&b, places[i], 8);
        las_put_number(&b, 1, 4);
        las_put_number(&b, COUNT / CHUNKS, 4);
    }
    CHECK(sample_is_right(&desc, COUNT / 4, COUNT / CHUNKS, COUNT / CHUNKS));
    file = las_write(&desc);
    stp_context* context = test_context(NULL, 1, NULL);
    stp_scan_info info;
    stp_scene* scene = read_as(context, &file, &(stp_import_desc){.scan = &info});
    CHECK(scene != NULL && info.copc && info.copc_nodes == CHUNKS && info.copc_levels == 3);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    free(file.bytes);
}

// Formats without samples, and files of no format, give none: that is no error.
void test_formats_without_samples_give_none(test_state* test)
{
    static const char* const names[] = {"a.obj", "a.nothing"};
    static const char text[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    for (int i = 0; i < 2; ++i) {
        stp_scene* scene = NULL;
        FILE* file = fopen(names[i], "w");
        CHECK(file != NULL && fputs(text, file) >= 0 && fclose(file) == 0);
        CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
        CHECK_EQUAL(STP_OK, stp_import_sample(scene, names[i], &(stp_import_desc){0}, 10));
        CHECK(scene->mesh_count == 0 && scene->point_set_count == 0);
        stp_scene_destroy(scene);
    }
    CHECK(log.errors == 0 && log.warnings == 0);
    stp_context_destroy(context);
}
