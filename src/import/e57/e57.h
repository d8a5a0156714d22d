// SPDX-License-Identifier: MIT
//
// Inside the E57 reader (ASTM E2807): pages (e57_pages.c), the tree of its XML section (e57_xml.c),
// the description of a scan (e57_scan.c), the packets of its records (e57_packets.c), and the
// records (e57_records.c).
#pragma once

#include "base/core/arena.h"
#include "import/reading/cloud.h"
#include "import/reading/scan_info.h"

enum { STP_E57_PAGE = 1024, STP_E57_PAYLOAD = 1020 };

/// A text followed by a line end and a zero byte.
typedef struct stp_e57_text {
    const char* bytes;
    size_t length;
} stp_e57_text;

typedef struct stp_e57_attribute {
    const char* name;
    stp_e57_text value;
    struct stp_e57_attribute* next;
} stp_e57_attribute;

typedef struct stp_e57_node {
    const char* name;
    stp_e57_text text;
    stp_e57_attribute* attributes;
    struct stp_e57_node *parent, *first, *last, *next;
} stp_e57_node;

typedef struct stp_e57 {
    stp_import* import;
    uint64_t logical_size;
    uint64_t xml_logical, xml_length;
    uint64_t section_bytes; ///< of all sections of points so far
    stp_arena arena;        ///< memory of the tree
    stp_e57_node* root;
} stp_e57;

/// Reads the header and checks every page.
/// @return STP_OK, STP_ERROR_FORMAT, STP_ERROR_TRUNCATED, STP_ERROR_UNSUPPORTED (logged)
STP_MUST_USE stp_result stp_e57_open_pages(stp_e57* e57);
/// Copies logical bytes; false if the file does not have them. Any thread.
bool stp_e57_copy(const stp_e57* e57, uint64_t logical, void* bytes, size_t size);
/// The bytes from a logical offset to the end of their page. @return their number; 0 at the end of
/// the file
size_t stp_e57_peek(const stp_e57* e57, uint64_t logical, const unsigned char** bytes);
/// Converts a physical offset; UINT64_MAX if it is in no page, or within a checksum.
uint64_t stp_e57_logical(const stp_e57* e57, uint64_t physical);

/// Reads the XML section. @return STP_OK, STP_ERROR_FORMAT, STP_ERROR_LIMIT,
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_e57_read_tree(stp_e57* e57);
/// The first child with a name; NULL if there is none or the node is NULL.
const stp_e57_node* stp_e57_child(const stp_e57_node* node, const char* name);
const stp_e57_text* stp_e57_attribute_of(const stp_e57_node* node, const char* name);
/// Reads a number of a text; false (and `value` unchanged) if it is not a number, or NULL.
bool stp_e57_number(const stp_e57_text* text, double* value);
bool stp_e57_integer(const stp_e57_text* text, int64_t* value);
bool stp_e57_unsigned(const stp_e57_text* text, uint64_t* value);

/// Fields of a record that are kept.
typedef enum stp_e57_slot {
    STP_E57_X, ///< or range
    STP_E57_Y, ///< or azimuth
    STP_E57_Z, ///< or elevation
    STP_E57_INVALID,
    STP_E57_INTENSITY,
    STP_E57_INTENSITY_INVALID,
    STP_E57_RED,
    STP_E57_GREEN,
    STP_E57_BLUE,
    STP_E57_COLOR_INVALID,
    STP_E57_ROW,
    STP_E57_COLUMN,
    STP_E57_NX,
    STP_E57_NY,
    STP_E57_NZ,
    STP_E57_RETURN,
    STP_E57_RETURNS,
    STP_E57_TIME,
    STP_E57_SLOTS,
} stp_e57_slot;

/// Encoding of a value: bits of its stream, low bits first.
typedef struct stp_e57_field {
    bool used, is_float;
    uint32_t stream;
    unsigned bits;        ///< 0: each value is `minimum`
    int64_t minimum;      ///< integers: added to the stored bits
    double scale, offset; ///< integers: value = integer * scale + offset
    double low, high;     ///< range of values, if specified; else low > high
} stp_e57_field;

typedef struct stp_e57_scan {
    const char* name; ///< NULL: it has none
    stp_affine pose;
    uint64_t record_count, section; ///< logical offset of the section
    uint32_t stream_count;
    stp_e57_field fields[STP_E57_SLOTS];
    bool has_places, spherical;
    uint32_t unused;        ///< fields that are not kept
    uint64_t columns, rows; ///< size of its grid; 0: it has none
    // location of its packets:
    uint64_t packet_count;
    uint64_t* places; ///< per used field and packet: offset of its bytes
    uint64_t* before; ///< per used field and packet, plus one: its bytes in earlier packets
} stp_e57_scan;

/// Reads the description of a scan. @return STP_OK, STP_ERROR_FORMAT, STP_ERROR_OUT_OF_MEMORY
/// (logged); has_places may be false
STP_MUST_USE stp_result stp_e57_describe_scan(stp_e57* e57, const stp_e57_node* node,
                                              uint32_t number, stp_e57_scan* scan);

/// Whether the reader keeps a field of records.
bool stp_e57_keeps(const char* name, bool spherical);

/// Describes all scans without reading a record. @return as stp_e57_describe_scan
STP_MUST_USE stp_result stp_e57_describe(stp_e57* e57, stp_scan_info* info);

/// Finds all packets of a scan and checks that they hold its records, and that the sections of all
/// scans so far fit the file together: scans that share one would take any amount of memory. Call
/// stp_e57_forget_packets in any case.
STP_MUST_USE stp_result stp_e57_find_packets(stp_e57* e57, uint32_t number, stp_e57_scan* scan);
void stp_e57_forget_packets(const stp_e57* e57, stp_e57_scan* scan);
/// Copies bytes [begin, begin + size) of a used field's stream, which must exist. Any thread.
void stp_e57_copy_stream(const stp_e57* e57, const stp_e57_scan* scan, stp_e57_slot slot,
                         uint64_t begin, unsigned char* bytes, size_t size);

/// Reads the records of a scan into the scene. @return STP_OK, or a failure, logged
STP_MUST_USE stp_result stp_e57_read_records(const stp_e57* e57, uint32_t number,
                                             const stp_e57_scan* scan);
