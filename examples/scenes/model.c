/* An imported mesh on a lit stage. Open Asset Import Library reads the file; the mesh is scaled to a fixed height,
   stood on a plinth and given its own materials where the file has any. */
#include <stdio.h>
#include <stdlib.h>

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include "scenes/scenes.h"

/* Where Debian's glmark2-data puts a mesh that everybody knows. */
#define DEFAULT_MODEL "/usr/share/glmark2/models/bunny.obj"

enum { MAX_TRIANGLES = 4000000 };
static const float model_height = 1.5f, plinth_height = 0.35f;

static vec3 from_assimp(struct aiVector3D v) { return vec3(v.x, v.y, v.z); }

static float material_number(const struct aiMaterial *m, const char *key, float otherwise)
{
    ai_real value = otherwise;
    aiGetMaterialFloatArray(m, key, 0, 0, &value, NULL);
    return clamp(value, 0.0f, 1.0f);
}

/* The file's diffuse colour, roughness and metalness; ivory with a glaze where the file says nothing. */
static void add_material(scene *s, const struct aiMaterial *m)
{
    struct aiColor4D c = { 0.78f, 0.72f, 0.62f, 1.0f }, e = { 0.0f, 0.0f, 0.0f, 1.0f };
    aiGetMaterialColor(m, AI_MATKEY_COLOR_DIFFUSE, &c);
    aiGetMaterialColor(m, AI_MATKEY_COLOR_EMISSIVE, &e);
    vec3 color = vec3(clamp(c.r, 0.02f, 0.95f), clamp(c.g, 0.02f, 0.95f), clamp(c.b, 0.02f, 0.95f));
    pt_material *out = scene_material(s, color, material_number(m, "$mat.roughnessFactor", 0.3f),
                                      material_number(m, "$mat.metallicFactor", 0.0f));
    out->emission = vec4(max(e.r, 0.0f), max(e.g, 0.0f), max(e.b, 0.0f), 0.0f);
}

static void bounds_of(const struct aiScene *a, vec3 *low, vec3 *high)
{
    *low = grey(INFINITY);
    *high = grey(-INFINITY);
    for (unsigned i = 0; i < a->mNumMeshes; i++)
        for (unsigned k = 0; k < a->mMeshes[i]->mNumVertices; k++) {
            vec3 p = from_assimp(a->mMeshes[i]->mVertices[k]);
            for (int c = 0; c < 3; c++) {
                (*low)[c] = min((*low)[c], p[c]);
                (*high)[c] = max((*high)[c], p[c]);
            }
        }
}

static void add_mesh(scene *s, const struct aiMesh *mesh)
{
    for (unsigned f = 0; f < mesh->mNumFaces; f++) {
        const struct aiFace *face = &mesh->mFaces[f];
        if (face->mNumIndices != 3) continue;
        scene_triangle t = { 0 };
        for (int k = 0; k < 3; k++) {
            unsigned v = face->mIndices[k];
            t.p[k] = from_assimp(mesh->mVertices[v]);
            t.n[k] = from_assimp(mesh->mNormals[v]);
            if (mesh->mTextureCoords[0]) {
                t.uv[k][0] = mesh->mTextureCoords[0][v].x;
                t.uv[k][1] = mesh->mTextureCoords[0][v].y;
            }
        }
        vec3 area = cross(t.p[1] - t.p[0], t.p[2] - t.p[0]);
        bool normals = dot(t.n[0], t.n[0]) > 0.0f && dot(t.n[1], t.n[1]) > 0.0f && dot(t.n[2], t.n[2]) > 0.0f;
        if (dot(area, area) > 0.0f && normals) scene_add_triangle(s, &t);
    }
}

static bool check_import(const struct aiScene *a, const char *path, char *error, size_t error_size)
{
    unsigned faces = 0;
    for (unsigned i = 0; i < a->mNumMeshes; i++) faces += a->mMeshes[i]->mNumFaces;
    if (faces > 0 && faces <= MAX_TRIANGLES) return true;
    snprintf(error, error_size, "%s: %u triangles, expected [1, %d]", path, faces, MAX_TRIANGLES);
    return false;
}

static bool import_model(scene *s, const char *path, char *error, size_t error_size)
{
    const unsigned steps = aiProcess_Triangulate | aiProcess_JoinIdenticalVertices | aiProcess_GenSmoothNormals |
                           aiProcess_PreTransformVertices | aiProcess_MakeLeftHanded | aiProcess_FlipWindingOrder |
                           aiProcess_SortByPType;
    const struct aiScene *a = aiImportFile(path, steps);
    if (!a) {
        snprintf(error, error_size, "%s: %s", path, aiGetErrorString());
        return false;
    }
    bool ok = check_import(a, path, error, error_size);
    vec3 low, high;
    bounds_of(a, &low, &high);
    float scale = model_height / max(max3(high - low), 1e-20f);
    vec3 foot = vec3(0.5f * (low[0] + high[0]), low[1], 0.5f * (low[2] + high[2]));
    scene_transform down = scene_translation(foot * -1.0f);
    scene_place(s, scene_compose(scene_translation(vec3(0.0f, plinth_height, 0.0f)),
                                 scene_compose(scene_scaling(scale), down)));
    for (unsigned i = 0; ok && i < a->mNumMeshes; i++) {
        add_material(s, a->mMaterials[a->mMeshes[i]->mMaterialIndex]);
        add_mesh(s, a->mMeshes[i]);
    }
    scene_place(s, scene_identity());
    aiReleaseImport(a);
    return ok;
}

static void add_stage(scene *s)
{
    static const float plinth[6][2] = { { 1.15f, 0.0f }, { 1.15f, 0.12f }, { 1.0f, 0.16f },
                                        { 1.0f, 0.33f }, { 0.98f, 0.35f }, { 0.0f, 0.35f } };
    pt_material *m = scene_material(s, vec3(0.42f, 0.30f, 0.20f), 0.15f, 0.0f);
    scene_texture(m, PT_TEXTURE_WOOD, 0.8f, vec3(0.26f, 0.17f, 0.10f), 0.35f, 0.0f);
    scene_add_panel(s, vec3(0.0f, 0.0f, 0.0f), vec3(0.0f, 0.0f, 60.0f), vec3(60.0f, 0.0f, 0.0f));
    m = scene_material(s, vec3(0.24f, 0.25f, 0.27f), 0.25f, 0.0f);
    scene_texture(m, PT_TEXTURE_NOISE, 3.0f, vec3(0.42f, 0.42f, 0.42f), 0.4f, 0.0f);
    scene_add_lathe(s, plinth, 6, 64);
    scene_material(s, vec3(0.95f, 0.93f, 0.90f), 0.05f, 1.0f);
    scene_add_sphere(s, vec3(-1.9f, 0.40f, -0.4f), 0.40f, 48);
    scene_material(s, vec3(0.10f, 0.30f, 0.42f), 0.35f, 0.0f);
    scene_add_sphere(s, vec3(1.8f, 0.32f, 0.5f), 0.32f, 40);
    scene_emitter(s, vec3(38.0f, 29.0f, 19.0f));
    scene_add_panel(s, vec3(-2.6f, 3.0f, -1.0f), vec3(0.25f, 0.18f, 0.0f), vec3(0.0f, 0.0f, 0.30f));
    scene_emitter(s, vec3(7.0f, 14.0f, 28.0f));
    scene_add_panel(s, vec3(2.8f, 2.2f, 1.2f), vec3(0.10f, -0.22f, 0.0f), vec3(0.0f, 0.0f, 0.30f));
}

bool scene_build_model(scene *s, const char *model, char *error, size_t error_size)
{
    scene_begin_object(s);
    add_stage(s);
    scene_begin_object(s);
    s->sky = (scene_sky){ vec3(0.16f, 0.24f, 0.42f), vec3(0.42f, 0.38f, 0.36f), vec3(0.10f, 0.09f, 0.08f), 0.05f };
    s->sun = (scene_sun){ vec3(0.55f, 0.65f, -0.60f), vec3(1.6f, 1.5f, 1.3f), 0.015f };
    return import_model(s, model ? model : DEFAULT_MODEL, error, error_size);
}

void scene_animate_model(scene *s, float time_s)
{
    float angle = 0.5f - 0.7f * time_s;
    s->camera.target = vec3(0.0f, 0.85f, 0.0f);
    s->camera.eye = s->camera.target + vec3(3.9f * sinf(angle), 1.05f, -3.9f * cosf(angle));
    s->camera.fov_y = 42.0f;
}
