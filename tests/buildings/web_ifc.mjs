// Triangle meshes of a model as web-ifc makes them: node web_ifc.mjs MODEL > MESHES
// One line of JSON per body: entity number, vertices (x, y, z in m, z up), triangles.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const { IfcAPI, LogLevel } = createRequire(`${process.cwd()}/`)("web-ifc");
const api = new IfcAPI();
await api.Init();
api.SetLogLevel(LogLevel.LOG_LEVEL_OFF);
const model = api.OpenModel(readFileSync(process.argv[2]), { COORDINATE_TO_ORIGIN: false });
api.StreamAllMeshes(model, (mesh) => {
  for (let i = 0; i < mesh.geometries.size(); i++) {
    const placed = mesh.geometries.get(i);
    const body = api.GetGeometry(model, placed.geometryExpressID);
    const raw = api.GetVertexArray(body.GetVertexData(), body.GetVertexDataSize());
    const faces = api.GetIndexArray(body.GetIndexData(), body.GetIndexDataSize());
    const m = placed.flatTransformation;
    const vertices = [];
    for (let k = 0; k < raw.length; k += 6) { // three coordinates and a normal
      const at = (row) => m[row] * raw[k] + m[row + 4] * raw[k + 1] + m[row + 8] * raw[k + 2] + m[row + 12];
      vertices.push(at(0), -at(2), at(1)); // web-ifc has y up
    }
    console.log(JSON.stringify([mesh.expressID, vertices, Array.from(faces)]));
    body.delete();
  }
});
