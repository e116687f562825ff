// SPDX-License-Identifier: Apache-2.0
// Keeps the document in the browser, so that it is there again after the page was closed.

import { kEmptyDocument, type Document } from "./document.ts";
import type { ModelFile } from "./protocol.ts";

const kStore = "documents";
/** Changes with the stores of the database. */
const kVersion = 1;

function database(): Promise<IDBDatabase> {
  const request = indexedDB.open("espalier", kVersion);
  request.onupgradeneeded = () => {
    if (!request.result.objectStoreNames.contains(kStore)) request.result.createObjectStore(kStore);
  };
  return promiseOf(request);
}

function promiseOf<T>(request: IDBRequest<T>): Promise<T> {
  return new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error);
  });
}

async function withStore<T>(
  mode: IDBTransactionMode,
  use: (store: IDBObjectStore) => IDBRequest<T>,
) {
  const opened = await database();
  try {
    return await promiseOf(use(opened.transaction(kStore, mode).objectStore(kStore)));
  } finally {
    opened.close();
  }
}

/** A document as this page or an older one, which had one model, saved it. */
type SavedDocument = Document & { model?: ModelFile | null };

/** The document that was saved last, if there is one and the browser gives it. */
export async function savedDocument(key: string): Promise<Document | null> {
  try {
    const saved = await withStore<SavedDocument>("readonly", (store) => store.get(key));
    if (!saved) return null;
    // An older page may have saved it, without the fields that are new.
    const { model, ...document } = saved;
    return { ...kEmptyDocument, ...document, models: saved.models ?? (model ? [model] : []) };
  } catch {
    return null; // The browser keeps nothing, in a private window say.
  }
}

let timer: ReturnType<typeof setTimeout> | undefined;

/** Saves the document soon; later calls replace earlier ones. */
export function saveSoon(document: Document, key: string): void {
  clearTimeout(timer);
  timer = setTimeout(() => void save(document, key), 400);
}

async function save(document: Document, key: string): Promise<void> {
  try {
    await withStore("readwrite", (store) => store.put(document, key));
  } catch {
    // The browser keeps nothing: there is no place to save to.
  }
}
