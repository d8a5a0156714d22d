// SPDX-License-Identifier: MIT
//
// E57 (ASTM E2807), the exchange format of terrestrial scanners: each scan is an object with its
// pose. Lengths are metres, up is z. Normals come from the records, or else from the neighbours in
// the grid of rows and columns. Pictures are not read.
#include "import/e57/e57.h"

#include <assert.h>
#include <string.h>

static uint64_t count_children(const stp_e57_node* node)
{
    uint64_t count = 0;
    for (const stp_e57_node* c = node != NULL ? node->first : NULL; c != NULL; c = c->next) {
        count += 1;
    }
    return count;
}

static stp_result read_scan(stp_e57* e57, const stp_e57_node* node, uint32_t number)
{
    stp_e57_scan scan;
    stp_import* import = e57->import;
    stp_result result = stp_e57_describe_scan(e57, node, number, &scan);
    if (result != STP_OK) {
        return result;
    }
    if (!scan.has_places) {
        stp_losses_add(&import->losses, STP_LOSS_SCAN, 1);
        return STP_OK;
    }
    assert(scan.stream_count >= 3 && scan.unused <= scan.stream_count);
    stp_losses_add(&import->losses, STP_LOSS_COLUMN, scan.unused);
    result = stp_e57_find_packets(e57, number, &scan);
    result = result == STP_OK ? stp_e57_read_records(e57, number, &scan) : result;
    stp_e57_forget_packets(e57, &scan);
    return result;
}

static stp_result read_system(stp_e57* e57)
{
    stp_import* import = e57->import;
    const stp_e57_node* system = stp_e57_child(e57->root, "coordinateMetadata");
    stp_result result = STP_OK;
    if (system != NULL && system->text.length > 0) {
        const char* text =
            stp_arena_copy_text(&e57->arena, system->text.bytes, system->text.length);
        result = text == NULL ? stp_fail_memory(import->context)
                              : stp_scene_set_coordinate_system(
                                    import->scene, import->scene->source_count - 1, text);
    }
    return result;
}

static stp_result read_scans(stp_e57* e57)
{
    stp_import* import = e57->import;
    stp_result result = STP_OK;
    uint32_t number = 0;
    const stp_e57_node* scans = stp_e57_child(e57->root, "data3D");
    for (const stp_e57_node* s = scans != NULL ? scans->first : NULL; s != NULL && result == STP_OK;
         s = s->next) {
        result = read_scan(e57, s, ++number);
    }
    stp_losses_add(&import->losses, STP_LOSS_SCANNER_PICTURE,
                   count_children(stp_e57_child(e57->root, "images2D")));
    return result;
}

static bool detect(const unsigned char* bytes, size_t size)
{
    return size >= 8 && memcmp(bytes, "ASTM-E57", 8) == 0;
}

static stp_result read(stp_import* import)
{
    stp_e57 e57 = {.import = import, .arena = stp_arena_create(import->context, 1 << 16)};
    stp_import_set_axes(import, import->desc.up != 0 ? import->desc.up : 'z', 1.0);
    stp_result result = stp_e57_open_pages(&e57);
    result = result == STP_OK ? stp_e57_read_tree(&e57) : result;
    result = result == STP_OK ? read_system(&e57) : result;
    if (result == STP_OK && import->desc.scan != NULL) {
        result = stp_e57_describe(&e57, import->desc.scan);
    }
    result = result == STP_OK ? read_scans(&e57) : result;
    stp_arena_destroy(&e57.arena);
    return result;
}

const stp_importer stp_importer_e57 = {
    .name = "e57", .title = "E57", .extensions = "e57", .detect = detect, .read = read};
