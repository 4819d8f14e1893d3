// Prints what dxf-parser finds in a DXF file as JSON: blocks with their entities, and the inserts.
const fs = require("fs");
const DxfParser = require("dxf-parser");
const drawing = new DxfParser().parseSync(fs.readFileSync(process.argv[2], "utf8"));
const brief = (entity) => ({
  type: entity.type, layer: entity.layer, text: entity.text, closed: entity.shape, position: entity.position,
  vertices: (entity.vertices || []).map((vertex) => [vertex.x, vertex.y]),
});
const blocks = Object.fromEntries(
  Object.entries(drawing.blocks).map(([name, block]) => [name, block.entities.map(brief)]));
const inserts = drawing.entities.filter((entity) => entity.type === "INSERT").map((entity) => entity.name);
console.log(JSON.stringify({ blocks, inserts }));
