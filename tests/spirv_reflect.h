/* spirv_reflect.h: as much of a SPIR-V module as the layout tests compare with nrd.h. Opcodes and enumerants: Khronos, "SPIR-V
   Specification", section 3. Asserts through cmocka that the module is what it expects; include cmocka.h first. */
#ifndef TESTS_SPIRV_REFLECT_H
#define TESTS_SPIRV_REFLECT_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

enum {
    SPV_OP_ENTRY_POINT = 15, SPV_OP_EXECUTION_MODE = 16, SPV_OP_CAPABILITY = 17, SPV_OP_TYPE_INT = 21, SPV_OP_TYPE_FLOAT = 22, SPV_OP_TYPE_VECTOR = 23,
    SPV_OP_TYPE_MATRIX = 24, SPV_OP_TYPE_IMAGE = 25, SPV_OP_TYPE_SAMPLED_IMAGE = 27, SPV_OP_TYPE_STRUCT = 30, SPV_OP_TYPE_POINTER = 32,
    SPV_OP_SPEC_CONSTANT = 50, SPV_OP_VARIABLE = 59, SPV_OP_DECORATE = 71, SPV_OP_MEMBER_DECORATE = 72
};
enum { SPV_DECORATION_SPEC_ID = 1, SPV_DECORATION_BLOCK = 2, SPV_DECORATION_COL_MAJOR = 5, SPV_DECORATION_MATRIX_STRIDE = 7, SPV_DECORATION_BINDING = 33,
       SPV_DECORATION_DESCRIPTOR_SET = 34, SPV_DECORATION_OFFSET = 35 };
enum { SPV_CAPABILITY_SHADER = 1, SPV_CAPABILITY_STORAGE_IMAGE_EXTENDED_FORMATS = 49, SPV_CAPABILITY_IMAGE_QUERY = 50 };
enum { SPV_STORAGE_UNIFORM_CONSTANT = 0, SPV_STORAGE_UNIFORM = 2, SPV_STORAGE_PUSH_CONSTANT = 9, SPV_STORAGE_BUFFER = 12 };
enum { SPV_EXECUTION_MODEL_GL_COMPUTE = 5, SPV_EXECUTION_MODE_LOCAL_SIZE = 17 };
enum { SPV_FORMAT_RGBA32F = 1, SPV_FORMAT_RGBA16F = 2, SPV_FORMAT_R32F = 3, SPV_FORMAT_RGBA8 = 4, SPV_FORMAT_R16F = 9, SPV_FORMAT_R8 = 15, SPV_FORMAT_R32UI = 33, SPV_FORMAT_RG32UI = 35, SPV_FORMAT_R16UI = 38 };

enum { SPIRV_MAX_IDS = 32768, SPIRV_MAX_MEMBERS = 96, SPIRV_MAX_BINDINGS = 40, SPIRV_MAX_SPEC = 16, SPIRV_MAX_CAPABILITIES = 16 };
#define SPIRV_NONE UINT32_MAX

typedef enum spirv_kind { SPIRV_ABSENT, SPIRV_UNIFORM_BLOCK, SPIRV_COMBINED_SAMPLER, SPIRV_STORAGE_IMAGE, SPIRV_STORAGE_BUFFER, SPIRV_OTHER } spirv_kind;

typedef struct spirv_binding {
    spirv_kind kind;
    bool is_uint;
    uint32_t format;     /* of storage images: SPV_FORMAT_ */
} spirv_binding;

typedef struct spirv_member { uint32_t offset, type; bool col_major; uint32_t matrix_stride; } spirv_member;
typedef struct spirv_block { uint32_t member_count; spirv_member members[SPIRV_MAX_MEMBERS]; } spirv_block;

typedef struct spirv_module {
    uint32_t version;
    uint32_t capabilities[SPIRV_MAX_CAPABILITIES], capability_count;
    uint32_t entry_points, execution_model, local_size[3];
    char entry_name[16];
    uint32_t spec_ids[SPIRV_MAX_SPEC], spec_count;
    bool other_set;      /* something lies in a descriptor set other than 0 */
    spirv_binding bindings[SPIRV_MAX_BINDINGS];
    spirv_block uniform, push;
    const uint32_t *definition[SPIRV_MAX_IDS]; /* of types: the instruction */
} spirv_module;

/* Instructions one after another; NULL at the end. */
static inline const uint32_t *spirv_next(const uint32_t *words, size_t count, const uint32_t *at)
{
    at = at ? at + (at[0] >> 16) : words + 5;
    return at < words + count ? at : NULL;
}

static inline uint32_t spirv_opcode(const uint32_t *at) { return at[0] & 0xffffu; }

static inline uint32_t spirv_decoration(const uint32_t *words, size_t count, uint32_t id, uint32_t decoration)
{
    for (const uint32_t *at = spirv_next(words, count, NULL); at; at = spirv_next(words, count, at))
        if (spirv_opcode(at) == SPV_OP_DECORATE && at[1] == id && at[2] == decoration) return at[0] >> 16 > 3 ? at[3] : 0;
    return SPIRV_NONE;
}

static inline void spirv_read_block(const uint32_t *words, size_t count, const spirv_module *m, uint32_t type, spirv_block *block)
{
    const uint32_t *definition = m->definition[type];
    block->member_count = (definition[0] >> 16) - 2;
    assert_true(block->member_count <= SPIRV_MAX_MEMBERS);
    for (uint32_t i = 0; i < block->member_count; i++) block->members[i].type = definition[2 + i];
    for (const uint32_t *at = spirv_next(words, count, NULL); at; at = spirv_next(words, count, at)) {
        if (spirv_opcode(at) != SPV_OP_MEMBER_DECORATE || at[1] != type) continue;
        spirv_member *member = &block->members[at[2]];
        if (at[3] == SPV_DECORATION_OFFSET) member->offset = at[4];
        if (at[3] == SPV_DECORATION_COL_MAJOR) member->col_major = true;
        if (at[3] == SPV_DECORATION_MATRIX_STRIDE) member->matrix_stride = at[4];
    }
}

static inline spirv_binding spirv_classify(const spirv_module *m, uint32_t type)
{
    spirv_binding b = { SPIRV_OTHER, false, 0 };
    const uint32_t *t = m->definition[type];
    bool combined = spirv_opcode(t) == SPV_OP_TYPE_SAMPLED_IMAGE;
    if (spirv_opcode(t) == SPV_OP_TYPE_STRUCT) b.kind = SPIRV_UNIFORM_BLOCK;
    if (combined) t = m->definition[t[2]];
    if (spirv_opcode(t) != SPV_OP_TYPE_IMAGE) return b;
    const uint32_t *texel = m->definition[t[2]];
    b.is_uint = spirv_opcode(texel) == SPV_OP_TYPE_INT && texel[3] == 0;
    b.format = t[8];
    bool flat = t[3] == 1 && t[4] != 1 && t[5] == 0 && t[6] == 0;   /* 2D, no depth comparison, no array, no multisampling */
    if (flat && combined) b.kind = SPIRV_COMBINED_SAMPLER;
    if (flat && !combined && t[7] == 2) b.kind = SPIRV_STORAGE_IMAGE;
    return b;
}

static inline void spirv_read_variable(const uint32_t *words, size_t count, spirv_module *m, const uint32_t *at)
{
    uint32_t storage = at[3], type = m->definition[at[1]][3], binding;
    if (storage == SPV_STORAGE_PUSH_CONSTANT) spirv_read_block(words, count, m, type, &m->push);
    if (storage != SPV_STORAGE_UNIFORM && storage != SPV_STORAGE_UNIFORM_CONSTANT && storage != SPV_STORAGE_BUFFER) return;
    binding = spirv_decoration(words, count, at[2], SPV_DECORATION_BINDING);
    assert_true(binding < SPIRV_MAX_BINDINGS);
    assert_int_equal(m->bindings[binding].kind, SPIRV_ABSENT);   /* no two at one binding */
    m->bindings[binding] = spirv_classify(m, type);
    if (storage == SPV_STORAGE_BUFFER) m->bindings[binding].kind = SPIRV_STORAGE_BUFFER;
    m->other_set |= spirv_decoration(words, count, at[2], SPV_DECORATION_DESCRIPTOR_SET) != 0;
    if (storage == SPV_STORAGE_UNIFORM && binding == 0) spirv_read_block(words, count, m, type, &m->uniform);
}

static inline void spirv_read_head(spirv_module *m, const uint32_t *at)
{
    switch (spirv_opcode(at)) {
    case SPV_OP_CAPABILITY:
        assert_true(m->capability_count < SPIRV_MAX_CAPABILITIES);
        m->capabilities[m->capability_count++] = at[1];
        break;
    case SPV_OP_ENTRY_POINT:
        m->entry_points++;
        m->execution_model = at[1];
        strncpy(m->entry_name, (const char *)&at[3], sizeof m->entry_name - 1);
        break;
    case SPV_OP_EXECUTION_MODE:
        if (at[2] == SPV_EXECUTION_MODE_LOCAL_SIZE) memcpy(m->local_size, &at[3], sizeof m->local_size);
        break;
    case SPV_OP_DECORATE:
        if (at[2] != SPV_DECORATION_SPEC_ID) break;
        assert_true(m->spec_count < SPIRV_MAX_SPEC);
        m->spec_ids[m->spec_count++] = at[3];
        break;
    case SPV_OP_TYPE_INT: case SPV_OP_TYPE_FLOAT: case SPV_OP_TYPE_VECTOR: case SPV_OP_TYPE_MATRIX: case SPV_OP_TYPE_IMAGE:
    case SPV_OP_TYPE_SAMPLED_IMAGE: case SPV_OP_TYPE_STRUCT: case SPV_OP_TYPE_POINTER:
        m->definition[at[1]] = at;
        break;
    }
}

static inline void spirv_read(const uint32_t *words, size_t size_bytes, spirv_module *m)
{
    size_t count = size_bytes / 4;
    memset(m, 0, sizeof *m);
    assert_true(size_bytes % 4 == 0 && count > 5 && words[0] == 0x07230203u && words[3] <= SPIRV_MAX_IDS);
    m->version = words[1];
    for (const uint32_t *at = spirv_next(words, count, NULL); at; at = spirv_next(words, count, at)) {
        assert_true(at[0] >> 16 != 0);
        spirv_read_head(m, at);
        if (spirv_opcode(at) == SPV_OP_VARIABLE) spirv_read_variable(words, count, m, at);
    }
}

#endif
