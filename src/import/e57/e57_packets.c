// SPDX-License-Identifier: MIT
#include "base/io/bytes.h"
#include "import/e57/e57.h"

#include <assert.h>

#define SECTION_HEADER 32
#define PACKET_HEADER 6
#define STREAMS_MAX 4096

enum { PACKET_INDEX, PACKET_DATA, PACKET_EMPTY };

typedef struct finder {
    stp_e57* e57;
    stp_e57_scan* scan;
    uint32_t number;
    uint64_t at, end; ///< logical
    size_t capacity_places, capacity_before;
    uint32_t used[STP_E57_SLOTS]; ///< streams, in the order of slots
    uint32_t used_count;
} finder;

static stp_result fail(const finder* f, const char* what)
{
    return stp_fail(f->e57->import->context, STP_ERROR_FORMAT, "%s: scan %u: %s",
                    f->e57->import->path, f->number, what);
}

static stp_result open_section(finder* f)
{
    unsigned char header[SECTION_HEADER];
    stp_e57* e57 = f->e57;
    uint64_t section = f->scan->section;
    if (section == UINT64_MAX || !stp_e57_copy(e57, section, header, sizeof(header)) ||
        header[0] != 1) {
        return fail(f, "no section of points at its offset");
    }
    uint64_t size = stp_read_u64(header + 8);
    f->at = stp_e57_logical(e57, stp_read_u64(header + 16));
    if (size < SECTION_HEADER || size > e57->logical_size - section || f->at < section ||
        (f->at > section + size && f->scan->record_count > 0)) {
        return fail(f, "its section of points extends beyond the end of the file");
    }
    f->end = section + size;
    e57->section_bytes += size;
    return e57->section_bytes <= e57->logical_size
               ? STP_OK
               : fail(f, "the sections of points up to its own are longer than the file");
}

// Adds the offset of each used stream's bytes in the packet at f->at.
static stp_result add_packet(finder* f, uint32_t size)
{
    stp_e57_scan* scan = f->scan;
    stp_context* context = f->e57->import->context;
    unsigned char head[PACKET_HEADER];
    unsigned char lengths[2 * STREAMS_MAX];
    (void)stp_e57_copy(f->e57, f->at, head, sizeof(head)); // was checked
    uint32_t count = stp_read_u16(head + 4);
    if (count != scan->stream_count ||
        !stp_e57_copy(f->e57, f->at + PACKET_HEADER, lengths, 2 * (size_t)count)) {
        return fail(f, "a packet and the records have different numbers of fields");
    }
    assert(count <= STREAMS_MAX && f->used_count <= STP_E57_SLOTS);
    size_t first = (size_t)scan->packet_count * f->used_count, needed = first + 2 * f->used_count;
    if (!STP_MAKE_ROOM(context, scan->places, f->capacity_places, needed) ||
        !STP_MAKE_ROOM(context, scan->before, f->capacity_before, needed)) {
        return stp_fail_memory(context);
    }
    uint64_t *places = scan->places, *before = scan->before;
    uint64_t offset = PACKET_HEADER + 2 * (uint64_t)count;
    for (uint32_t stream = 0; stream < count; ++stream) {
        uint32_t length = stp_read_u16(lengths + 2 * (size_t)stream);
        for (uint32_t i = 0; i < f->used_count; ++i) {
            if (f->used[i] == stream) {
                places[first + i] = f->at + offset;
                before[first + i] = scan->packet_count == 0 ? 0 : before[first + i];
                before[first + f->used_count + i] = before[first + i] + length;
            }
        }
        offset += length;
    }
    scan->packet_count += 1;
    return offset <= size ? STP_OK : fail(f, "the streams of a packet are longer than the packet");
}

static stp_result read_packets(finder* f)
{
    stp_result result = STP_OK;
    while (result == STP_OK && f->end - f->at >= 4 && f->at < f->end) {
        assert(f->at <= f->end && f->end <= f->e57->logical_size);
        unsigned char head[PACKET_HEADER] = {0};
        size_t held = f->end - f->at < PACKET_HEADER ? 4 : PACKET_HEADER;
        if (!stp_e57_copy(f->e57, f->at, head, held)) {
            return fail(f, "its section of points extends beyond the end of the file");
        }
        uint32_t size = stp_read_u16(head + 2) + 1u;
        if (size > f->end - f->at || size % 4 != 0 || head[0] > PACKET_EMPTY) {
            return fail(f, "a packet has an invalid size or an unknown type");
        }
        if (head[0] == PACKET_DATA) {
            result = size >= PACKET_HEADER ? add_packet(f, size) : fail(f, "a packet is too short");
        }
        f->at += size;
    }
    return result;
}

// Whether each stream has enough bits for all records.
static stp_result check_streams(const finder* f)
{
    const stp_e57_scan* scan = f->scan;
    unsigned placed = 0;
    uint32_t index = 0;
    for (int slot = 0; slot < STP_E57_SLOTS; ++slot) {
        const stp_e57_field* field = &scan->fields[slot];
        if (!field->used) {
            continue;
        }
        placed += slot <= STP_E57_Z ? field->bits : 0;
        uint64_t held =
            scan->packet_count == 0 ? 0 : scan->before[scan->packet_count * f->used_count + index];
        if (field->bits > 0 && held * 8 / field->bits < scan->record_count) {
            return stp_fail(f->e57->import->context, STP_ERROR_TRUNCATED,
                            "%s: scan %u: has %llu records, but its packets hold %llu",
                            f->e57->import->path, f->number, (unsigned long long)scan->record_count,
                            (unsigned long long)(held * 8 / field->bits));
        }
        index += 1;
    }
    return placed > 0 || scan->record_count <= 1 ? STP_OK : fail(f, "all of its points coincide");
}

stp_result stp_e57_find_packets(stp_e57* e57, uint32_t number, stp_e57_scan* scan)
{
    finder f = {.e57 = e57, .scan = scan, .number = number};
    for (int slot = 0; slot < STP_E57_SLOTS; ++slot) {
        if (scan->fields[slot].used) {
            assert(scan->fields[slot].stream < scan->stream_count);
            f.used[f.used_count++] = scan->fields[slot].stream;
        }
    }
    if (scan->stream_count > STREAMS_MAX) {
        return fail(&f, "its records have more than 4096 fields");
    }
    stp_result result = scan->record_count > 0 ? open_section(&f) : STP_OK;
    result = result == STP_OK && scan->record_count > 0 ? read_packets(&f) : result;
    return result == STP_OK ? check_streams(&f) : result;
}

void stp_e57_forget_packets(const stp_e57* e57, stp_e57_scan* scan)
{
    stp_free(e57->import->context, scan->places);
    stp_free(e57->import->context, scan->before);
    scan->places = scan->before = NULL;
}

void stp_e57_copy_stream(const stp_e57* e57, const stp_e57_scan* scan, stp_e57_slot slot,
                         uint64_t begin, unsigned char* bytes, size_t size)
{
    uint32_t index = 0, used = 0;
    for (int i = 0; i < STP_E57_SLOTS; ++i) {
        index += i < (int)slot && scan->fields[i].used;
        used += scan->fields[i].used;
    }
    assert(scan->fields[slot].used && index < used);
    uint64_t low = 0, high = scan->packet_count;
    while (high - low > 1) { // the last packet with no more than `begin` bytes before it
        uint64_t middle = low + (high - low) / 2;
        if (scan->before[middle * used + index] <= begin) {
            low = middle;
        } else {
            high = middle;
        }
    }
    for (uint64_t packet = low; size > 0 && packet < scan->packet_count; ++packet) {
        uint64_t before = scan->before[packet * used + index];
        uint64_t length = scan->before[(packet + 1) * used + index] - before;
        uint64_t from = begin - before, held = length - from;
        assert(before <= begin && from <= length);
        size_t part = held < size ? (size_t)held : size;
        (void)stp_e57_copy(e57, scan->places[packet * used + index] + from, bytes, part);
        bytes += part;
        size -= part;
        begin += part;
    }
    assert(size == 0 && "check_streams found enough bytes");
}
